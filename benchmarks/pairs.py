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
from functools import lru_cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import numpy as np

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.engine import random, rows as engine_rows, table as engine_table, turnover
from ecs_eco.life import births
from ecs_eco.nervous.sensors import nearest
from ecs_eco.nervous.sensors.own import feel_together
from ecs_eco.nervous.sensors.smell import smell_together
from ecs_eco.record import recorder, rows
from ecs_eco.space.geometry import Places
from ecs_eco.space.index import Index
from ecs_eco.space.nearest import Found
from ecs_eco.systems import perish, reproduce, spread

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
PAGE = np.zeros((128, 64))  # receives sums that a kernel makes and another sum replaces


def never(*_: Any) -> Any:
    """Decline to do the work in the fast way."""
    return None


def alone(world: World, function: Any) -> None:
    """Read each sensor of a kind alone."""
    for table in world.tables.values():
        if (nerves := table.species.nerves) is not None:
            nerves.senses = [
                (sense._replace(together=None) if sense.together is function else sense, width)
                for sense, width in nerves.senses
            ]


def by_numpy(world: World) -> None:
    """Compute happiness with numpy."""
    for table in world.tables.values():
        if (nerves := table.species.nerves) is not None:
            nerves.happiness.steps = None


def note_births(table: Any, columns: Any, some: Any, parents: Any, second: Any, *rest: Any) -> None:
    """Like `rows.note_births`, with all sums by numpy."""
    tick, s, page, into = rest
    if rows.Metabolism in table:
        page[s, rows.ENDOWED] += np.add.reduce(table[rows.Metabolism].energy.take(some), dtype=np.float64)
    place = rows.NOWHERE if into is None else into.more(some.size)
    rows.born(some, parents, second, tick, s, table.high, columns, PAGE, place)


def note_deaths(table: Any, columns: Any, some: Any, tick: int, dt: float, ticking: bool, *rest: Any) -> None:
    """Like `rows.note_deaths`, with all sums by numpy."""
    s, page, died, into = rest
    first = 0 if ticking else len(rows.FLOWS)
    if rows.Metabolism in table:
        m = table[rows.Metabolism]
        for i, column in enumerate((m.taken, m.burnt, m.given, m.energy)[first:], rows.FLOW + first):
            page[s, i] += np.add.reduce(column.take(some), dtype=np.float64)
    place = rows.NOWHERE if into is None else into.more(some.size)
    rows.lose(some, tick, dt, s, first, table.high, columns, PAGE, died, place)


def in_two_steps(mine: Any, targets: Any, radius: float, *rest: Any) -> None:
    """Like `nearest` with the kernel `see`, as two kernels."""
    entry, distance2, split, _, (poses, seen) = rest
    NEAREST(mine, targets, radius, entry, distance2, split)
    places = Places(targets.x, targets.y, targets.z)
    found = Found(entry, distance2)
    split(nearest._bearings, mine.n, poses, places, mine.space.extent, found, seen)


def unsorted_dying(table: Any) -> np.ndarray:
    """Like `Table.dying`, with numpy's sort."""
    found = DYING(table)
    return found.take(table.uid.take(found).argsort()) if found.size else found


def searched_dying(table: Any) -> np.ndarray:
    """Like `Table.dying`, with the kernel in every case."""
    found = np.empty(engine_rows.FEW + table.high // 16, np.int64)
    n = engine_rows.list_dying(found, table.high, table.layout().rows)
    return found[:n] if n <= engine_rows.FEW else found[:n].take(table.uid.take(found[:n]).argsort())


def look_at_all(sites: Any, *arguments: Any) -> np.ndarray:
    """Like `Sites.look`, with all plants."""
    sites._single = False
    return LOOK(sites, *arguments)


def next_version(table: Any, *_: Any) -> None:
    """Like `Table._goes_on`, without a list of changes."""
    table.version += 1


@lru_cache(maxsize=64)
def key_of(seed: int, tick: int) -> np.uint64:
    """Like `tick_key`, one tick at a time."""
    return np.uint64(random.mix_int(random.mix_int(seed) + tick))


NEAREST, DYING, LOOK = nearest.nearest, engine_table.Table.dying, spread.Sites.look
Change = tuple[Any, str, Any]  # an object, an attribute and its value
PAIRS: dict[str, tuple[list[Change], Callable[[World], None] | None]] = {
    "nothing": ([], None),
    "a few newborns placed by one kernel": ([(births, "small_brood", never)], None),
    "a species' limits checked by one kernel": ([(perish.Perish, "_limits", never)], None),
    "own properties read together": ([], lambda world: alone(world, feel_together)),
    "noses read together": ([], lambda world: alone(world, smell_together)),
    "nearest body and its direction in one kernel": ([(nearest, "nearest", in_two_steps)], None),
    "happiness formulas in one kernel": ([], by_numpy),
    "unobserved deaths in one kernel": ([(turnover.Unheard, "bury", never)], None),
    "a few births and deaths summed by a kernel": (
        [(recorder, "note_births", note_births), (recorder, "note_deaths", note_deaths)],
        None,
    ),
    "a few deaths and parents sorted by a kernel": (
        [(engine_table.Table, "dying", unsorted_dying), (reproduce, "FEW", -1)],
        None,
    ),
    "no deaths recognized without a kernel": ([(engine_table.Table, "dying", searched_dying)], None),
    "neighbor indexes renewed": ([(Index, "renew", lambda *_: False)], None),
    "plants' sites renewed": ([(spread.Sites, "look", look_at_all)], None),
    "indexes and sites renewed": (
        [
            (Index, "renew", lambda *_: False),
            (spread.Sites, "look", look_at_all),
            (engine_table.Table, "_goes_on", next_version),
        ],
        None,
    ),
    "keys of 64 ticks at once": ([(random, "tick_key", key_of)], None),
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
