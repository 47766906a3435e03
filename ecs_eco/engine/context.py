"""The esper context of one world: its processors, in the order of a tick, and an entity for each organism."""

from __future__ import annotations

import gc
import itertools
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import esper
import numpy as np

from ecs_eco.engine import turns
from ecs_eco.engine.phases import PHASES
from ecs_eco.engine.table import Table

_serial = itertools.count(1)
LAST = 999_999  # the place in a phase after all systems


class Context:
    """esper's view of one world. Worlds do not mix: esper has one current context, which `inside` enters."""

    def __init__(self) -> None:
        self.name = f"ecs-eco {next(_serial)}"

    @contextmanager
    def inside(self) -> Iterator[None]:
        """Make this world esper's current context; afterwards restore the one before."""
        with turns.turn:
            outer = esper.current_world
            if outer != self.name:
                esper.switch_world(self.name)
            try:
                yield
            finally:
                switch_back(outer)

    def add(self, processor: esper.Processor, phase: str, place: int) -> None:
        """Hand a processor to esper with a priority that follows from its phase and its place in it."""
        with self.inside():
            esper.add_processor(processor, priority=-(PHASES.index(phase) * (LAST + 1) + place))

    def sync(self, tables: Iterable[Table], handles: Callable[[Table, int], list[Any]]) -> None:
        """Bring esper's entities up to date: one for each living organism, with its `handles(table, row)`."""
        tables = [t for t in tables if (t.entity_uid != t.uid).any()]
        if not tables:
            return
        collecting = gc.isenabled()
        gc.disable()  # garbage collection would scan 100,000 new handles again and again
        with self.inside():
            for table in tables:
                for row in np.flatnonzero(table.entity_uid != table.uid):
                    if table.entity_uid[row] and esper.entity_exists(int(table.entity[row])):
                        esper.delete_entity(int(table.entity[row]), immediate=True)
                    if table.uid[row]:
                        table.entity[row] = esper.create_entity(*handles(table, int(row)))
                table.entity_uid[:] = table.uid
        if collecting:
            gc.enable()

    def end(self) -> None:
        """Forget all that esper knows of this world."""
        if self.name in esper.list_worlds():
            if esper.current_world == self.name:
                esper.switch_world("default")
            esper.delete_world(self.name)


def switch_back(outer: str) -> None:
    """Make a context esper's current one again; the default one if it is gone."""
    if esper.current_world != outer:
        esper.switch_world(outer if outer in esper.list_worlds() else "default")
