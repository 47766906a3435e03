"""The behavior of entities, one system per file. Each system selects columns and calls a kernel.

Systems never import each other; shared code belongs in `ecs_eco.life`, `ecs_eco.nervous`, `ecs_eco.space` or
a component. `ORDER` lists them in the order of a tick, from which `schedule.py` selects those of a world.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import file_of, lazy

if TYPE_CHECKING:
    from ecs_eco.systems.age import Age as Age
    from ecs_eco.systems.build import Build as Build
    from ecs_eco.systems.carry import Carry as Carry
    from ecs_eco.systems.collide import Collide as Collide
    from ecs_eco.systems.compress import Compress as Compress
    from ecs_eco.systems.decay import Decay as Decay
    from ecs_eco.systems.decide import Decide as Decide
    from ecs_eco.systems.decompose import Decompose as Decompose
    from ecs_eco.systems.diffuse import Diffuse as Diffuse
    from ecs_eco.systems.dilute import Dilute as Dilute
    from ecs_eco.systems.drift import Drift as Drift
    from ecs_eco.systems.exchange_heat import ExchangeHeat as ExchangeHeat
    from ecs_eco.systems.exchange_matter import ExchangeMatter as ExchangeMatter
    from ecs_eco.systems.feed import Feed as Feed
    from ecs_eco.systems.feel import Feel as Feel
    from ecs_eco.systems.give_birth import GiveBirth as GiveBirth
    from ecs_eco.systems.grow import Grow as Grow
    from ecs_eco.systems.grow_up import GrowUp as GrowUp
    from ecs_eco.systems.hatch import Hatch as Hatch
    from ecs_eco.systems.intervene import Intervene as Intervene
    from ecs_eco.systems.learn import Learn as Learn
    from ecs_eco.systems.leave_remains import LeaveRemains as LeaveRemains
    from ecs_eco.systems.maintain_nerves import MaintainNerves as MaintainNerves
    from ecs_eco.systems.mate import Mate as Mate
    from ecs_eco.systems.mature import Mature as Mature
    from ecs_eco.systems.metabolise import Metabolise as Metabolise
    from ecs_eco.systems.move import Move as Move
    from ecs_eco.systems.nurse import Nurse as Nurse
    from ecs_eco.systems.perish import Perish as Perish
    from ecs_eco.systems.provide import Provide as Provide
    from ecs_eco.systems.react import React as React
    from ecs_eco.systems.renew import Renew as Renew
    from ecs_eco.systems.reproduce import Reproduce as Reproduce
    from ecs_eco.systems.reset_flows import ResetFlows as ResetFlows
    from ecs_eco.systems.respawn import Respawn as Respawn
    from ecs_eco.systems.sense import Sense as Sense
    from ecs_eco.systems.shade import Shade as Shade
    from ecs_eco.systems.slow_down import SlowDown as SlowDown
    from ecs_eco.systems.spread import Spread as Spread
    from ecs_eco.systems.take_stock import TakeStock as TakeStock
    from ecs_eco.systems.travel import Travel as Travel
    from ecs_eco.systems.use_land import UseLand as UseLand
    from ecs_eco.systems.wander import Wander as Wander

# the systems of a tick by phase, in running order
ORDER = {
    "environment": "Intervene UseLand ResetFlows TakeStock Dilute Shade Grow Diffuse Mature SlowDown",
    "sense": "Sense",
    "feel": "Feel",
    "learn": "Learn",
    "decide": "Decide",
    "move": "Wander Move Drift Travel Carry",
    "interact": "Collide Feed Nurse Mate Build",
    "metabolise": "Metabolise MaintainNerves ExchangeMatter React Decay Decompose ExchangeHeat Compress "
    "GrowUp Age",
    "die": "Hatch Perish LeaveRemains",  # at its end, the rows of dying organisms are freed
    "reproduce": "Provide Renew Respawn Reproduce GiveBirth Spread",  # at its end, newborns get rows
    "record": "",  # the recorder of a recorded world runs here
}
__getattr__ = lazy(__name__, {f".{file_of(name)}": name for name in sorted(" ".join(ORDER.values()).split())})
