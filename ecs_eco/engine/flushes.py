"""Steps of the world itself between systems: deaths and births take effect, and esper is kept up to date."""

import weakref
from typing import Any

import esper


class _OfWorld(esper.Processor):
    def __init__(self, world: Any) -> None:
        self.world = weakref.proxy(world)


class Deaths(_OfWorld):
    """The end of the phase `die`: the dying leave their rows."""

    def process(self, *_: Any) -> None:
        """Flush the deaths."""
        self.world.flush_deaths()


class Births(_OfWorld):
    """The end of the phase `reproduce`: the newborn get their rows."""

    def process(self, *_: Any) -> None:
        """Flush the births."""
        self.world.flush_births()


class Touched(_OfWorld):
    """After a plain processor: it may have moved what it saw, or written what no kernel can take."""

    def __init__(self, world: Any, after: esper.Processor) -> None:
        super().__init__(world)
        self.after = after

    def process(self, *_: Any) -> None:
        """Look at what was written."""
        self.world.touch()
        self.world.admit(refuse=self.world.debug is None)
