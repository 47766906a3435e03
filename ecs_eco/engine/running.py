"""Ticks one after the other, each whole: hooks before, a stop in between, and what is left after an error."""

import time
from collections.abc import Callable
from typing import Any

import esper

from ecs_eco.engine import turns
from ecs_eco.engine.context import switch_back
from ecs_eco.engine.interruption import Patience, stopped
from ecs_eco.engine.living import LivingWorld, Underway


def live(
    world: LivingWorld, ticks: int, progress: Callable[[int, int], Any] | None, outside: str, mark: Underway
) -> None:
    """Let ticks of a world pass as `World.run` says, and let esper show the context `outside` again."""
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
                _pass(world, mark)
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
            with turns.turn:
                switch_back(outside)


def _pass(world: LivingWorld, mark: Underway) -> None:
    """Let one tick pass; the mark stands until it is complete."""
    world.underway, world.ticking = mark, True
    with turns.turn:
        outside = esper.current_world if world.apart else ""
        world.context.show()
        if world.workers.helpers:
            world.workers.tick(world.context.process, lambda: sum(t.n for t in world.tables.values()))
        else:
            world.context.process()
        world.tick += 1
        if world.apart:
            esper.switch_world(outside)
    world.ticking, world.underway = False, None
    if turns.turn.waiting:
        turns.turn.leave()
