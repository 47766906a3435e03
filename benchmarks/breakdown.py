"""Measure the parts of a tick: nanoseconds per animal for each system, with one and with two threads.

python benchmarks/breakdown.py [--sizes 10000 30000 100000]
"""

import argparse
import statistics
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import numpy as np

from ecs_eco import World, njit
from ecs_eco.compiled.workers import Workers


def timed(world: World) -> Counter[str]:
    """Make every system and the networks' forward passes add their time [s] to the returned counter."""
    spent: Counter[str] = Counter()

    def watch(owner: Any, method: str, name: str) -> None:
        inner = getattr(owner, method)

        def watched(*arguments: Any, **named: Any) -> Any:
            start = time.perf_counter()
            result = inner(*arguments, **named)
            spent[name] += time.perf_counter() - start
            return result

        setattr(owner, method, watched)

    for system in world.systems:
        watch(system, "process", type(system).__name__)
    for table in world.tables.values():
        if table.species.nerves is not None:
            watch(table.species.nerves.brain, "forward", "within Decide: networks")
    for method in ("flush_deaths", "flush_births"):
        watch(world, method, method)
    watch(world, "index", "within several: neighbor indexes")
    return spent


def networks_alone(n: int = 20_000, repeats: int = 9) -> str:
    """Return how many times as fast the networks alone run on two threads, each with half of the animals: the
    highest possible gain on this machine."""
    import threading

    from ecs_eco.learning import Brain
    from ecs_eco.learning.inference import infer_shared

    brain, rng = Brain(24, (3, 3)), np.random.default_rng(0)
    seen, logits, values = (
        rng.standard_normal((24, n), dtype=np.float32),
        np.empty((n, 6), np.float32),
        np.empty(n, np.float32),
    )

    def think(first: int, last: int) -> None:
        for _ in range(20):
            infer_shared(first, last, seen, brain.weights, brain.layers, logits, values)

    def both() -> None:
        other = threading.Thread(target=think, args=(0, n // 2))
        other.start()
        think(n // 2, n)
        other.join()

    ratios = []
    for turn in range(repeats + 1):
        took = []
        for work in (lambda: think(0, n), both):
            start = time.perf_counter()
            work()
            took.append(time.perf_counter() - start)
        if turn:  # the first turn compiles the kernels
            ratios.append(took[0] / took[1])
    return f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"


@njit
def nothing(first: int, last: int, a: Any, b: Any, c: Any, d: Any, e: Any, f: Any, g: Any, h: Any) -> None:
    """Take eight arrays and do nothing."""


def handing_over(repeats: int = 2000) -> str:
    """Return the time it takes to divide an empty kernel between two threads and wait for it: median and 90th
    percentile [µs]."""
    workers, arrays, took = Workers(2), [np.zeros(100) for _ in range(8)], []
    for _ in range(repeats):
        start = time.perf_counter()
        workers.split(nothing, 10_000, *arrays)
        took.append(1e6 * (time.perf_counter() - start))
    workers.end()
    took = sorted(took[repeats // 10 :])  # the first calls compile the kernel
    return f"{statistics.median(took):.0f} ({took[len(took) * 9 // 10]:.0f})"


def main() -> None:
    """Profile each size with one and two threads in turn."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[10_000, 30_000, 100_000])
    columns: dict[str, dict[str, float]] = {}
    for animals in parser.parse_args().sizes:
        for threads in (1, 2):
            world = World.from_config(
                _bench.savanna(animals), seed=1, policies="untrained", threads=threads, training=True
            )
            world.workers.pace.divide = lambda: True  # in each tick
            world.run(5)
            spent, ticks = timed(world), max(5, 600_000 // animals)
            start = time.perf_counter()
            world.run(ticks)
            whole = time.perf_counter() - start
            columns[f"{animals:,}, {threads} thread{'s' * (threads > 1)}"] = {
                k: v / ticks / animals * 1e9 for k, v in [("whole tick", whole), *spent.items()]
            }
    names = sorted(
        {n for c in columns.values() for n in c}, key=lambda n: -next(iter(columns.values())).get(n, 0.0)
    )
    _bench.save(
        "breakdown",
        "Parts of a tick [ns per animal]",
        [{"part": n, **{c: round(v.get(n, 0.0), 1) for c, v in columns.items()}} for n in names],
        {
            "speed of the networks on two threads, relative to one": networks_alone(),
            "an empty kernel on two threads, median (90th percentile) [µs]": handing_over(),
        },
    )


if __name__ == "__main__":
    main()
