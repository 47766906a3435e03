"""Where the time of a tick goes: nanoseconds per animal of each system, with one and with two threads.

    python benchmarks/breakdown.py [--sizes 30000 100000]
"""

import argparse
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

from ecs_eco import World


def timed(world: World) -> Counter[str]:
    """Let every system and the networks' forward passes add up their time [s] in the counter
    that is returned."""
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
            watch(table.species.nerves.brain, "forward", "of Decide: the networks")
    for method in ("flush_deaths", "flush_births"):
        watch(world, method, method)
    watch(world, "index", "of several: neighbour indexes")
    return spent


def main() -> None:
    """Profile each size with one and two threads in turn."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[30_000, 100_000])
    columns: dict[str, dict[str, float]] = {}
    for animals in parser.parse_args().sizes:
        for threads in (1, 2):
            world = World.from_config(_bench.savanna(animals), seed=1, policies="untrained", threads=threads,
                                      training=True)
            world.run(5)
            spent, ticks = timed(world), max(5, 600_000 // animals)
            start = time.perf_counter()
            world.run(ticks)
            whole = time.perf_counter() - start
            columns[f"{animals:,}, {threads} thread{'s' * (threads > 1)}"] = {
                k: v / ticks / animals * 1e9 for k, v in [("whole tick", whole), *spent.items()]}
    names = sorted({n for c in columns.values() for n in c},
                   key=lambda n: -next(iter(columns.values())).get(n, 0.0))
    _bench.save("breakdown", "Where the time of a tick goes [ns per animal]",
                [{"part": n, **{c: round(v.get(n, 0.0), 1) for c, v in columns.items()}} for n in names])


if __name__ == "__main__":
    main()
