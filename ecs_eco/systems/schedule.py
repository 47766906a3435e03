"""The systems of a tick by phase, in running order."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ecs_eco.engine.system import System
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

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

SCHEDULE: dict[str, tuple[type[System], ...]] = {
    "environment": (
        Intervene,
        UseLand,
        ResetFlows,
        TakeStock,
        Dilute,
        Shade,
        Grow,
        Diffuse,
        Mature,
        SlowDown,
    ),
    "sense": (Sense,),
    "feel": (Feel,),
    "learn": (Learn,),
    "decide": (Decide,),
    "move": (Wander, Move, Drift, Travel, Carry),
    "interact": (Collide, Feed, Nurse, Mate, Build),
    "metabolise": (Metabolise, ExchangeMatter, React, Decay, Decompose, ExchangeHeat, Compress, GrowUp, Age),
    "die": (Hatch, Perish, LeaveRemains),  # at its end, the rows of dying organisms are freed
    "reproduce": (Provide, Renew, Reproduce, GiveBirth, Spread),  # at its end, newborns get rows
    "record": (),  # the recorder of a recorded world runs here
}
"""The shipped systems by phase. A world's own systems run after the shipped systems of the same phase."""

RESPAWNING = SCHEDULE | {"reproduce": (Provide, Renew, Respawn, Reproduce, Spread)}
"""The schedule of training worlds with constant population sizes: the dead are replaced, and there are no
births."""


def schedule(respawn: bool = False, tables: Iterable[Table] | None = None) -> list[System]:
    """Return new systems for a world, in the order they run in a tick.

    Parameters
    ----------
    respawn : bool, default False
        Whether to use the schedule of pre-training, in which dead organisms are replaced at once.
    tables : iterable of Table, optional
        Leave out systems that none of these tables needs; by default, all systems are included.

    Returns
    -------
    list of System

    Examples
    --------
    >>> from ecs_eco.systems.schedule import schedule
    >>> type(schedule()[0]).__name__
    'Intervene'
    """
    phases, given = RESPAWNING if respawn else SCHEDULE, None if tables is None else list(tables)
    return [
        system()
        for systems in phases.values()
        for system in systems
        if given is None or system.asked_for is None or any(map(system.asked_for, given))
    ]
