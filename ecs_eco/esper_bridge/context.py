"""The esper context of one world: the state that esper uses while this world is current."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import esper

from ecs_eco.engine.living import LivingWorld
from ecs_eco.esper_bridge import turns
from ecs_eco.esper_bridge.registry import Registry

_serial = itertools.count(1)
PARTS = 11  # number of parts of the state that esper stores for a context


class Context:
    """esper's view of one world. Worlds stay separate: `inside` makes this context esper's current one."""

    def __init__(self, world: LivingWorld) -> None:
        self.name = f"ecs-eco {next(_serial)}"
        self.registry = Registry(world)
        # no iteration over all contexts: collecting garbage may remove one of them at any moment
        state = esper._context_map.get(esper.current_world)
        if state is not None and len(state) != PARTS:
            raise RuntimeError(
                f"esper {esper.version} stores its worlds differently from esper 3.9, which this package "
                "requires; install esper==3.9"
            )
        esper._context_map[self.name] = self.registry.state

    def require(self) -> None:
        """Raise RuntimeError if esper has deleted this world."""
        if self.name not in esper._context_map:
            raise RuntimeError(
                f"esper.delete_world({self.name!r}) has deleted {self.registry.called}; you can still "
                "inspect and save it"
            )

    def show(self) -> None:
        """Make esper show this world. Raises RuntimeError if esper has deleted it."""
        if self.name not in esper._context_map:
            self.require()
        if esper.current_world != self.name:
            esper.switch_world(self.name)

    @contextmanager
    def inside(self) -> Iterator[None]:
        """Make this world esper's current context; restore the previous one afterward."""
        with turns.turn:
            outer = esper.current_world
            self.show()
            try:
                yield
            finally:
                switch_back(outer)
        turns.turn.leave()

    def tell(self, event: str, numbers: list[int], *more: list[Any]) -> None:
        """Dispatch an esper event with the given arguments for each entity in a list."""
        with self.inside():
            for arguments in zip(numbers, *more, strict=True):
                esper.dispatch_event(event, *arguments)

    def end(self) -> None:
        """Discard everything that esper stores for this world."""
        if self.name in esper._context_map:
            if esper.current_world == self.name:
                esper.switch_world("default")
            esper.delete_world(self.name)


def switch_back(outer: str) -> None:
    """Switch esper back to a context, or to the default context if that context no longer exists."""
    if esper.current_world != outer:
        esper.switch_world(outer if outer in esper._context_map else "default")
