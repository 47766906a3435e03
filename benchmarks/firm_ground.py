"""Measure the cost of safety checks: outside input is validated, every tick is completed, worlds with several
threads take turns, and Ctrl-C waits for the end of a tick.

    python benchmarks/firm_ground.py [--turns 150]

One world in one process runs a few ticks per turn; turns are of four kinds, in random order: one `run` of all
these ticks or `run(1)` for each, with complete or bare ticks. Bare ticks run only the systems (neighbors are
searched again after a run, because they may have moved). Ratios compare consecutive turns, so they depend
neither on other work on the machine nor on the process's memory layout; 95% intervals are bootstrapped over
sets of consecutive turns. To compare commits, use the less precise before_after.py.
"""

import argparse
import random
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

from before_after import WORLDS, interval

from ecs_eco import World
from ecs_eco.config import load


def bare(world: World, ticks: int) -> None:
    """Run ticks without checking outside writes and without protection against interruption."""
    world._touch()
    world.context.show()
    for _ in range(ticks):
        world._pass_tick()
        world.tick += 1


def each(one: Callable[[World, int], Any]) -> Callable[[World, int], None]:
    """Return a function that runs ticks one by one."""

    def work(world: World, ticks: int) -> None:
        for _ in range(ticks):
            one(world, 1)

    return work


KINDS: dict[str, Callable[[World, int], Any]] = {
    "run": World.run,
    "bare": bare,
    "run(1)": each(World.run),
    "bare(1)": each(bare),
}


def compare(world: World, ticks: int, turns: int) -> dict[str, list[float]]:
    """Return the durations [s] of turns, by kind."""
    draws = random.Random(1)
    took: dict[str, list[float]] = {kind: [] for kind in KINDS}
    for _ in range(turns):
        for kind in draws.sample(list(KINDS), len(KINDS)):
            start = time.perf_counter()
            KINDS[kind](world, ticks)
            took[kind].append(time.perf_counter() - start)
    return took


def main() -> None:
    """Compare three worlds and store the result."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--turns", type=int, default=150)
    turns, rows = parser.parse_args().turns, []
    for name, (shipped, changes, ticks) in WORLDS.items():
        world = World.from_config(load(shipped, changes), seed=1, record=False).run(5)
        took = compare(world, ticks, turns)
        row: dict[str, Any] = {
            "world": name,
            "organisms": sum(t.n for t in world.tables.values()),
            "ms per tick": 1000 * statistics.median(took["bare"]) / ticks,
        }
        for kind, without in (("run", "bare"), ("run(1)", "bare(1)")):
            ratio = interval([a / b for a, b in zip(took[kind], took[without], strict=True)])
            row[f"{kind}, relative to bare ticks"] = "{ratio:.4f} [{from:.4f}, {to:.4f}]".format(**ratio)
        rows.append(row)
    _bench.save(
        "firm_ground",
        "The cost of checking outside input and completing every tick",
        rows,
        {"turns of each kind": turns, "ticks per turn": "40; 12 with 10,000 animals"},
    )


if __name__ == "__main__":
    main()
