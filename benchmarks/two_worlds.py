"""Run two worlds of 10,000 animals one after the other, then at the same time in two threads and in two processes.

    python benchmarks/two_worlds.py [--rounds 10]

Each world has one thread. A round runs all three ways in turn; "times as much work per second" compares a way
with one after the other in the same round. Two processes share nothing, so they show what the machine allows.
"digests" states whether both worlds end as they do alone.
"""

import argparse
import multiprocessing
import statistics
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

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
TICKS = 120
_together: Any = None  # barrier at which both worlds of a process pool start


def live(seed: int, wait: Callable[[], Any] | None = None) -> tuple[float, str]:
    """Return the seconds of a world's run, and its digest."""
    world = World.from_config(load("predator-prey", LARGE), seed=seed, learn=False, record=False).run(20)
    (wait or _together.wait)()
    begin = time.perf_counter()
    world.run(TICKS)
    return time.perf_counter() - begin, world.digest()


def _meet(barrier: Any) -> None:
    """Keep the barrier of a process pool."""
    global _together
    _together = barrier


def _pair(way: str) -> tuple[float, list[str]]:
    """Return the seconds that both worlds take in one way, and their digests."""
    if way == "one after the other":
        ends = [live(seed, lambda: None) for seed in (1, 2)]
        return sum(took for took, _ in ends), [digest for _, digest in ends]
    if way == "two threads":
        with ThreadPoolExecutor(2) as threads:
            ends = list(threads.map(live, (1, 2), [threading.Barrier(2).wait] * 2))
    else:
        fresh = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(2, fresh, _meet, (fresh.Barrier(2),)) as processes:
            ends = list(processes.map(live, (1, 2)))
    return max(took for took, _ in ends), [digest for _, digest in ends]


def main() -> None:
    """Measure all three ways."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--rounds", type=int, default=10)
    rounds = parser.parse_args().rounds
    ways = ("one after the other", "two threads", "two processes")
    runs = [{way: _pair(way) for way in ways} for _ in range(rounds)]
    rows = []
    for way in ways:
        gain = sorted(run[ways[0]][0] / run[way][0] for run in runs)
        rows.append(
            {
                "way": way,
                "ticks": f"2 × {TICKS}",
                "seconds, median": statistics.median(run[way][0] for run in runs),
                "times as much work per second, median": statistics.median(gain),
                "least": gain[0],
                "most": gain[-1],
                "digests": "equal" if all(run[way][1] == run[ways[0]][1] for run in runs) else "different",
            }
        )
    _bench.save(
        "two_worlds", "Two worlds of 10,000 animals in one thread, two threads and two processes", rows
    )


if __name__ == "__main__":
    main()
