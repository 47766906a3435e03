"""The interface of a world for lower layers of the engine, and the mark of an unfinished action."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

if TYPE_CHECKING:
    import esper

    from ecs_eco.engine.phases import Schedule
    from ecs_eco.engine.schema import Handle
    from ecs_eco.engine.table import Table


class Underway:
    """An action that must not leave a world half-changed; it is `world.underway` until it is complete.

    It is set before the first change and removed after the last, so no interruption can clear it.
    """

    def __init__(self, action: str, running: bool = True) -> None:
        self.action, self.running = action, running
        self.where, self.cause = "", ""

    def text(self, world: LivingWorld) -> str:
        """Return the action as text, for messages."""
        return f"tick {world.tick}" if self.action == "tick" else self.action


class LivingWorld(Protocol):
    """The attributes of a world that the engine below `World` uses; `ecs_eco.engine.world` implements
    them."""

    name: str
    tick: int
    tables: dict[str, Table]
    causes: list[str]
    next_uid: int
    underway: Underway | None
    ticking: bool
    stopping: bool
    stopped: bool
    owner: threading.Thread
    schedule: Schedule
    debug: Any

    @property
    def time(self) -> float: ...

    before_tick: list[Callable[[], Any]]
    on_death: list[Callable[[Table, np.ndarray], Any]]
    on_birth: list[Callable[[Table, np.ndarray, np.ndarray, np.ndarray], Any]]
    on_departure: list[Callable[[Table, np.ndarray, np.ndarray], Any]]
    on_arrival: list[Callable[[Table, np.ndarray, np.ndarray], Any]]

    def flush(self) -> None: ...
    def _flush_deaths(self) -> None: ...
    def _flush_births(self) -> None: ...
    def _touch(self) -> None: ...
    def _pass_tick(self) -> None: ...
    def _admit(self, refuse: bool = True) -> None: ...
    def kill(self, uid: int, cause: str = "culled", killer: int = 0) -> None: ...
    def spawn(self, name: str, *components: object, n: int = 1, parent: int = 0) -> None: ...
    def run(self, ticks: int) -> LivingWorld: ...
    def add_system(
        self, system: esper.Processor, phase: str | None = None, priority: int | None = None
    ) -> Any: ...
    def remove_processor(self, processor: esper.Processor) -> None: ...
    def _handle(self, table: Table, row: int, component: type[Any]) -> Any: ...
    def _values(self, table: Table, components: Iterable[Handle]) -> dict[tuple[type, str], np.ndarray]: ...
