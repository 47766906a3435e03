"""The systems of a tick by phase, in running order."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ecs_eco import systems
from ecs_eco.engine.system import System

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

Phases = dict[str, tuple[type[System], ...]]


def _without(system: str) -> Phases:
    """Return all shipped systems by phase, except one."""
    return {
        phase: tuple(getattr(systems, name) for name in names.split() if name != system)
        for phase, names in systems.ORDER.items()
    }


SCHEDULE = _without("Respawn")
"""The shipped systems by phase. A world's own systems run after the shipped systems of the same phase."""
RESPAWNING = _without("GiveBirth")
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
        for of_phase in phases.values()
        for system in of_phase
        if given is None or system.asked_for is None or any(map(system.asked_for, given))
    ]
