"""A tick in two halves: a program outside the world reads its state after the first half and acts before the
second."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ecs_eco.engine.interruption import Patience, require_whole, stopped
from ecs_eco.engine.living import Underway
from ecs_eco.engine.phases import priority_of

if TYPE_CHECKING:
    from ecs_eco.engine.world import World


class Halves:
    """The two halves of each tick of one world, split at a phase.

    Between the halves, a tick is in progress: you can inspect the world, but not run or save it. The first
    Ctrl-C takes effect at the end of a half; after a second one, or an error, you can only inspect the world.
    """

    def __init__(self, phase: str) -> None:
        self.border = priority_of(phase, 0)
        self.begun = False  # whether the first half is complete and the second is not
        self.beginning = False  # whether hooks are being called for a tick in halves

    def begin(self, world: World) -> None:
        """Run the hooks in `before_tick`, then the first half; do nothing if it is already complete."""
        if self.begun:
            return
        world._mine()
        require_whole(world, "begin a tick")
        world._admit(refuse=world.debug is None)
        world._touch()
        if world.tick == 0:
            world.flush()
        self._hooks(world)
        self._pass(world, True)

    def finish(self, world: World) -> None:
        """Run the second half, which ends the tick. Raises RuntimeError if no tick has begun."""
        if not self.begun:
            raise RuntimeError(f"world {world.name!r}: no tick has begun; call begin() first")
        world._mine()
        require_whole(world, "finish a tick", within=True)
        self._pass(world, False)

    def _hooks(self, world: World) -> None:
        self.beginning = True
        try:
            for call in tuple(world.before_tick):
                call()
        finally:
            self.beginning = False
        world.stopped, world.stopping = world.stopping, False

    def _pass(self, world: World, first: bool) -> None:
        with Patience(world) as patience:
            if first:
                world.underway, world.ticking = Underway("tick"), True
            try:
                with world._entered():
                    world._act([p for p in world.schedule if (p.priority > self.border) == first])
            except BaseException as error:
                stopped(world, error)
                self.begun = world.ticking = False
                raise
            self.begun = first
            if not first:
                world.tick += 1
                world.ticking, world.underway = False, None
            patience.over()
