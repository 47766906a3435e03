"""What happens to entities, one system a file: it picks columns and calls one kernel.

Systems never import each other; what two of them share belongs to `ecs_eco.lifecycle`, `ecs_eco.nervous`,
`ecs_eco.space` or a component. Their order belongs to `schedule.py`.
"""

from ecs_eco._lazy import lazy

_HOME = {
    "Intervene": "intervene", "ResetFlows": "reset_flows", "Shade": "shade", "Grow": "grow",
    "Diffuse": "diffuse", "Sense": "sense", "Feel": "feel", "Learn": "learn", "Decide": "decide",
    "Move": "move", "Drift": "drift", "Collide": "collide", "Feed": "feed", "Mate": "mate",
    "Metabolise": "metabolise", "ExchangeHeat": "exchange_heat", "Compress": "compress", "Age": "age",
    "Perish": "perish", "TakeStock": "take_stock", "Dilute": "dilute", "React": "react",
    "ExchangeMatter": "exchange_matter", "Decompose": "decompose", "Provide": "provide",
    "LeaveRemains": "leave_remains", "Reproduce": "reproduce", "GiveBirth": "give_birth", "Spread": "spread",
    "Respawn": "respawn", "Mature": "mature",
    "GrowUp": "grow_up", "Nurse": "nurse", "Hatch": "hatch",
    "Decay": "decay", "Renew": "renew", "Travel": "travel",
    "Carry": "carry", "Build": "build", "UseLand": "use_land",
}  # fmt: skip
__all__ = list(_HOME)
__getattr__ = lazy(__name__, {name: f"{__name__}.{module}" for name, module in _HOME.items()})
