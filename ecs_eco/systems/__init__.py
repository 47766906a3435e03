"""The behavior of entities, one system per file. Each system selects columns and calls a kernel.

Systems never import each other; shared code belongs in `ecs_eco.life`, `ecs_eco.nervous`, `ecs_eco.space` or
a component. `schedule.py` defines their order.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import file_of, lazy, listing

if TYPE_CHECKING:
    from ecs_eco.systems.age import Age
    from ecs_eco.systems.build import Build
    from ecs_eco.systems.carry import Carry
    from ecs_eco.systems.collide import Collide
    from ecs_eco.systems.compress import Compress
    from ecs_eco.systems.decay import Decay
    from ecs_eco.systems.decide import Decide
    from ecs_eco.systems.decompose import Decompose
    from ecs_eco.systems.diffuse import Diffuse
    from ecs_eco.systems.dilute import Dilute
    from ecs_eco.systems.drift import Drift
    from ecs_eco.systems.exchange_heat import ExchangeHeat
    from ecs_eco.systems.exchange_matter import ExchangeMatter
    from ecs_eco.systems.feed import Feed
    from ecs_eco.systems.feel import Feel
    from ecs_eco.systems.give_birth import GiveBirth
    from ecs_eco.systems.grow import Grow
    from ecs_eco.systems.grow_up import GrowUp
    from ecs_eco.systems.hatch import Hatch
    from ecs_eco.systems.intervene import Intervene
    from ecs_eco.systems.learn import Learn
    from ecs_eco.systems.leave_remains import LeaveRemains
    from ecs_eco.systems.mate import Mate
    from ecs_eco.systems.mature import Mature
    from ecs_eco.systems.metabolise import Metabolise
    from ecs_eco.systems.move import Move
    from ecs_eco.systems.nurse import Nurse
    from ecs_eco.systems.perish import Perish
    from ecs_eco.systems.provide import Provide
    from ecs_eco.systems.react import React
    from ecs_eco.systems.renew import Renew
    from ecs_eco.systems.reproduce import Reproduce
    from ecs_eco.systems.reset_flows import ResetFlows
    from ecs_eco.systems.respawn import Respawn
    from ecs_eco.systems.sense import Sense
    from ecs_eco.systems.shade import Shade
    from ecs_eco.systems.slow_down import SlowDown
    from ecs_eco.systems.spread import Spread
    from ecs_eco.systems.take_stock import TakeStock
    from ecs_eco.systems.travel import Travel
    from ecs_eco.systems.use_land import UseLand
    from ecs_eco.systems.wander import Wander

__all__ = [
    "Age",
    "Build",
    "Carry",
    "Collide",
    "Compress",
    "Decay",
    "Decide",
    "Decompose",
    "Diffuse",
    "Dilute",
    "Drift",
    "ExchangeHeat",
    "ExchangeMatter",
    "Feed",
    "Feel",
    "GiveBirth",
    "Grow",
    "GrowUp",
    "Hatch",
    "Intervene",
    "Learn",
    "LeaveRemains",
    "Mate",
    "Mature",
    "Metabolise",
    "Move",
    "Nurse",
    "Perish",
    "Provide",
    "React",
    "Renew",
    "Reproduce",
    "ResetFlows",
    "Respawn",
    "Sense",
    "Shade",
    "SlowDown",
    "Spread",
    "TakeStock",
    "Travel",
    "UseLand",
    "Wander",
]
__getattr__ = lazy(__name__, {name: f"{__name__}.{file_of(name)}" for name in __all__})
__dir__ = listing(globals(), __all__)
