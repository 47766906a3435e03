"""What happens to entities, a file per system: it picks columns and calls one kernel.

Systems never import each other; what two of them share lives in `space`, `nervous`, a component, or a file `_….py` without a system.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "Intervene": "intervene", "Reckon": "reckon", "Shade": "shade", "Grow": "grow", "Diffuse": "diffuse", "Sense": "sense", "Feel": "feel",
    "Learn": "learn", "Decide": "decide", "Move": "move", "Drift": "drift", "Collide": "collide", "Feed": "feed", "Mate": "mate",
    "Metabolise": "metabolise", "Age": "age", "Perish": "perish",
    "Leave": "leave", "Reproduce": "reproduce", "Bear": "bear", "Spread": "spread", "Respawn": "respawn",
}  # fmt: skip
__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"ecs_eco.systems has no {name!r}; it has {', '.join(_HOME)}")
    return getattr(import_module(f"ecs_eco.systems.{_HOME[name]}"), name)
