"""Run the checks before and after every system and flush, and once before each tick."""

from __future__ import annotations

import os
import weakref
from collections.abc import Callable
from typing import Any

import esper
import numpy as np

from ecs_eco.debug.columns import StaleHandle, budget
from ecs_eco.debug.comparison import Before
from ecs_eco.debug.invariants import Invariants
from ecs_eco.engine.phases import priority_of
from ecs_eco.engine.schema import Columns
from ecs_eco.engine.table import Table
from ecs_eco.space.world import SpatialWorld

BETWEEN = "code between ticks"


def start(world: SpatialWorld) -> Debug | None:
    """Return the checks for a new world if ECS_ECO_DEBUG is set to a value other than 0, otherwise None."""
    return None if os.environ.get("ECS_ECO_DEBUG", "0") in ("", "0") else Debug(world)


class Debug:
    """The checks of one world, whose systems and flushes run inside `watch`."""

    def __init__(self, world: SpatialWorld) -> None:
        self.world = weakref.proxy(world)
        self.before: Before | None = None  # the world before the running system
        self.drift: dict[str, float] = {}  # energy changes between ticks, which no ledger records
        world.schedule.put(Opening(world), priority_of("environment", 0))

    def guard(self, table: Table, component: type[Any], row: int) -> Guard:
        """Return the guarded columns of a component for the handle of one row."""
        return Guard(table, component, row, int(table.uid[row]))

    def act(self, processor: esper.Processor) -> None:
        """Run a processor, and check its changes if it is a system."""
        if processor in self.world.systems:
            self.watch(type(processor).__name__, processor.process, processor)
        else:
            processor.process()

    def watch(
        self, name: str, act: Callable[[], object], system: esper.Processor | None = None, flush: bool = False
    ) -> None:
        """Run a system or flush, and check its changes; a flush within a system splits the system's check in
        two."""
        outer = self.before
        if outer is not None:
            outer.compare()
        elif not self.world.ticking:
            Invariants(self.world, BETWEEN).check()
        self.before = Before(self.world, name, system, flush)
        try:
            act()
            self.before.compare()
            if outer is not None:
                outer = Before(self.world, outer.name, outer.system, outer.flush)
        except BaseException:
            outer = None
            raise
        finally:
            self.before = outer


class Opening(esper.Processor):
    """The first processor of a tick, so that changes between ticks are not blamed on the first system."""

    def __init__(self, world: SpatialWorld) -> None:
        self.world = weakref.proxy(world)

    def process(self, *_: object) -> None:
        """Check the world at the start of the tick, and note changes missing from this tick's ledger."""
        Invariants(self.world, BETWEEN).check()
        recorder = self.world.recorder
        for s, name in enumerate(recorder.names if recorder is not None else ()):
            page, table = recorder._ledger[recorder._at, s], self.world.tables[name]
            energy = budget(table).get("energy")
            stock = 0.0 if energy is None else energy[table.rows()].sum(dtype=np.float64)
            known = recorder._stock[s] + page["endowed"] - page["lost"] - page["burnt"]
            if recorder.migrations is not None:
                known += page["imported"] - page["exported"]
            self.world.debug.drift[name] = stock - known


class Guard(Columns):
    """The columns behind an organism's handle in debug mode: access fails once the row belongs to another
    organism."""

    __slots__ = ("_component", "_row", "_table", "_uid")
    __setattr__ = object.__setattr__  # type: ignore[assignment]  # has no columns of its own

    def __init__(self, table: Table, component: type[Any], row: int, uid: int) -> None:
        table[component]  # raises an error if the component is unknown
        self._table, self._component, self._row, self._uid = table, component, row, int(uid)

    def __getattr__(self, name: str) -> Any:
        table, row, uid = self._table, self._row, self._uid
        if table.uid[row] != uid:
            here = int(table.uid[row])
            now = f"row {row} belongs to uid {here} now" if here else f"row {row} is free now"
            fate = f"uid {uid} is dead, and {now}; store uids and call world.get again"
            if (table.uid == uid).any():
                fate = (
                    f"uid {uid} is no longer in row {row}, because rows were reordered; call world.get again"
                )
            raise StaleHandle(
                f"tables[{table.name!r}]: {self._component.__name__}.{name} through an outdated "
                f"handle: {fate}"
            )
        return getattr(table[self._component], name)

    @property
    def __dict__(self) -> dict[str, Any]:  # type: ignore[override]
        return {name: getattr(self, name) for name in self._component.fields}
