"""Run two worlds of 10,000 animals one after the other, and at the same time in two threads.

    python benchmarks/two_worlds.py [--rounds 5]

Each world has one thread. The table shows the shortest wall-clock time in any round, and how many times as
much work per second two threads do. "digests" states whether both worlds end as they do alone.
"""

import argparse
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

from ecs_eco import World
from ecs_eco.config import load

LARGE = {
    "space.size": [640.0, 640.0],
    "species.grass.count": 25_000,
    "species.deer.count": 9000,
    "species.wolf.count": 1000,
}
TICKS, PART = 60, 3


def live(seed: int, together: threading.Barrier) -> tuple[list[float], str]:
    """Return the seconds of each part of a world's run, and its digest."""
    world = World.from_config(load("predator-prey", LARGE), seed=seed, learn=False, record=False).run(20)
    took = []
    for _ in range(TICKS // PART):
        together.wait()
        begin = time.perf_counter()
        world.run(PART)
        took.append(time.perf_counter() - begin)
    return took, world.digest()


def main() -> None:
    """Measure both."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--rounds", type=int, default=5)
    given = parser.parse_args()
    parts: dict[bool, list[list[float]]] = {False: [], True: []}
    ends = set()
    for _ in range(given.rounds):
        with ThreadPoolExecutor(1) as thread:
            alone = [thread.submit(live, seed, threading.Barrier(1)).result() for seed in (1, 2)]
        with ThreadPoolExecutor(2) as threads:
            both = [*threads.map(live, (1, 2), [threading.Barrier(2)] * 2)]
        parts[False].append([a + b for a, b in zip(alone[0][0], alone[1][0], strict=True)])
        parts[True].append([max(a, b) for a, b in zip(both[0][0], both[1][0], strict=True)])
        ends.add((tuple(end for _, end in alone), tuple(end for _, end in both)))
    after, same = (sum(map(min, zip(*parts[at_once], strict=True))) for at_once in (False, True))
    rows = [
        {
            "ticks": f"2 × {TICKS}",
            "one after the other [s]": after,
            "at the same time [s]": same,
            "times as much work per second": after / same,
            "digests": "equal" if all(one == other for one, other in ends) else "different",
        }
    ]
    _bench.save("two_worlds", "Two worlds of 10,000 animals in one thread and in two", rows)


if __name__ == "__main__":
    main()
