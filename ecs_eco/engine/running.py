"""Run ticks one after another: call hooks before each tick, stop on request, and mark the world after an
error."""

import time
from collections.abc import Callable
from typing import Any

from ecs_eco.engine.interruption import Patience, stopped
from ecs_eco.engine.living import LivingWorld, Underway


def live(world: LivingWorld, ticks: int, progress: Callable[[int, int], Any] | None, mark: Underway) -> None:
    """Run ticks of a world, as `World.run` describes."""
    with Patience(world) as patience:
        try:
            if world.tick == 0:
                world.flush()
            shown = time.monotonic()
            for done in range(1, ticks + 1):
                for call in tuple(world.before_tick) if world.before_tick else ():
                    call()
                if world.stopping:
                    break
                world.underway, world.ticking = mark, True  # the mark remains until the tick is complete
                world._pass_tick()
                world.tick += 1
                world.ticking, world.underway = False, None
                patience.over()
                if progress is not None and (done == ticks or time.monotonic() - shown > 0.1):
                    shown = time.monotonic()
                    progress(done, ticks)
                if world.stopping:
                    break
        except BaseException as error:
            stopped(world, error)
            raise
        finally:
            mark.running = world.ticking = False
            world.stopped, world.stopping = world.stopping, False
