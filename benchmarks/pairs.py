"""Measure the gain from each pair of implementations: work for which a second, faster implementation gives the
same results as a simpler one.

    python benchmarks/pairs.py [--rounds 7] [--pairs NAME …]

In each round, every variant builds the same worlds, and the variants take turns after every few ticks, in one
process. A variant uses the simple implementation of one pair, so all variants do the same work tick by tick,
and must end with the same digest. A job's time is the sum over its parts of the shortest processor time in
any round; `median` compares whole rounds. "nothing" is the control: its difference from 1 is noise.
Jobs: README's predator-prey, recorded, with frozen policies (400 ticks) and with policies that learn (192
ticks), and 10,000 animals (40 ticks), on one thread.
"""

import argparse
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.life import births

LARGE = {
    "space.size": [640.0, 640.0],
    "species.grass.count": 25_000,
    "species.deer.count": 9000,
    "species.wolf.count": 1000,
}
JOBS: dict[str, tuple[dict[str, Any], bool, int, int]] = {  # settings, learning, ticks in all and per part
    "1,000 animals": ({}, False, 400, 10),
    "1,000 animals that learn": ({}, True, 192, 8),
    "10,000 animals": (LARGE, False, 40, 2),
}


def by_numpy(world: World) -> None:
    """Compute happiness with numpy."""
    for table in world.tables.values():
        if (nerves := table.species.nerves) is not None:
            nerves.happiness.steps = None


Change = tuple[Any, str, Any]  # an object, an attribute and its value
PAIRS: dict[str, tuple[list[Change], Callable[[World], None] | None]] = {
    "nothing": ([], None),
    "a few newborns placed by one kernel": ([(births, "small_brood", lambda *_: None)], None),
    "happiness formulas in one kernel": ([], by_numpy),
}


@contextmanager
def without(pair: str) -> Iterator[None]:
    """Use the simple implementation of a pair."""
    with ExitStack() as stack:
        for owner, name, value in PAIRS[pair][0]:
            stack.enter_context(patch.object(owner, name, value))
        yield


def one_round(
    job: str, pairs: list[str], folder: str, number: int
) -> tuple[dict[str, list[float]], set[str]]:
    """Return the processor seconds of each part of a job by variant, and the digests at its end."""
    settings, learn, ticks, part = JOBS[job]
    worlds, took = {}, {pair: [] for pair in pairs}
    for k, pair in enumerate(pairs):
        with without(pair):
            record = False if settings else f"{folder}/{number}-{k}"
            world = World.from_config(load("predator-prey", settings), seed=1, learn=learn, record=record)
            if (prepare := PAIRS[pair][1]) is not None:
                prepare(world)
            worlds[pair] = world.run(20)
    for n in range(ticks // part):
        for pair in pairs if (n + number) % 2 else pairs[::-1]:
            with without(pair):
                begin = time.process_time()
                worlds[pair].run(part)
                took[pair].append(time.process_time() - begin)
    return took, {world.digest() for world in worlds.values()}


def main() -> None:
    """Measure all pairs."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--pairs", nargs="*", choices=[*PAIRS], default=[*PAIRS])
    parser.add_argument("--jobs", nargs="*", choices=[*JOBS], default=[*JOBS])
    given = parser.parse_args()
    pairs = ["fast", *(pair for pair in given.pairs)]
    PAIRS["fast"] = ([], None)
    out: dict[str, dict[str, Any]] = {pair: {"without": pair} for pair in pairs}
    ends: dict[str, int] = {}
    for job in given.jobs:
        rounds = []
        with tempfile.TemporaryDirectory() as folder:
            for number in range(given.rounds + 1):
                took, digests = one_round(job, pairs, folder, number)
                rounds.append(took)
                ends[job] = len(digests)
        rounds = rounds[1:]  # the first reads the kernels
        best = {pair: sum(map(min, zip(*(took[pair] for took in rounds), strict=True))) for pair in pairs}
        for pair in pairs:
            if pair == "fast":
                out[pair][job] = f"{best[pair]:.3g} s"
                continue
            median = statistics.median(sum(took[pair]) / sum(took["fast"]) for took in rounds)
            out[pair][job] = f"{best[pair] / best['fast']:.3f} ({median:.3f})"
        print(job, {pair: row[job] for pair, row in out.items()}, flush=True)
    notes = {"rounds": given.rounds, "different digests": ", ".join(f"{j}: {n}" for j, n in ends.items())}
    _bench.save("pairs", "Jobs without the fast implementation of one pair", [*out.values()], notes)


if __name__ == "__main__":
    main()
