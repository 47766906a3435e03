"""Measure organism-steps per second for animals that sense, decide and act, with the ledger, the recorder and
causes of death enabled.

    python benchmarks/animals.py [--sizes 1000 10000 100000] [--learn] [--threads 1 2]

Plants are simulated but not counted.
"""

import argparse
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import numpy as np

from ecs_eco import World
from ecs_eco.components import Position


def in_reach(world: World, name: str, sample: int = 300) -> float:
    """Return the mean number of bodies within the sensing radii of some animals of a species, counted by
    brute force."""
    table = world.tables[name]
    rows = table.by_uid()[:: max(1, table.n // sample)]
    total = 0
    for sensor in world.config.species[name].sensors:
        if sensor.kind == "nearest":
            others = world.tables[sensor.target]
            p, q, r = table[Position], others[Position], others.rows()
            for row in rows:
                d = np.stack([q.x[r] - p.x[row], q.y[r] - p.y[row]])
                size = np.array(world.space.size[:2])[:, None]
                d -= size * np.round(d / size)
                total += int(((d**2).sum(0) < sensor.range**2).sum()) - (others is table)
    return total / len(rows)


def measure(animals: int, threads: int, learn: bool) -> dict[str, object]:
    """Time a world of this size after a warm-up; with learning, over complete rollouts."""
    world = World.from_config(
        _bench.savanna(animals), seed=1, policies="untrained", threads=threads, training=True, learn=learn
    )
    world.run(65 if learn else 5)
    ticks = 64 if learn else max(4, min(400, 200_000 // animals))
    times = []
    for _ in range(3 if learn else 5):
        start = time.perf_counter()
        world.run(ticks)
        times.append((time.perf_counter() - start) / ticks)
    n = world.tables["grazer"].n + world.tables["hunter"].n
    best = min(times)
    row = {
        "animals": n,
        "plants": world.tables["plant"].n,
        "threads": threads,
        "learning": learn,
        "neighbors in reach": round(in_reach(world, "grazer"), 1),
        "ns per animal per tick": best / n * 1e9,
        "M organism-steps/s": n / best / 1e6,
    }
    if learn:
        row["rollout bytes per transition"] = world.tables[
            "grazer"
        ].species.nerves.learner.rollout.nbytes_per_transition
    return row


def main() -> None:
    """Measure all sizes in turn."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument(
        "--sizes", type=int, nargs="+", default=[1000, 3000, 10_000, 30_000, 100_000, 300_000, 1_000_000]
    )
    parser.add_argument("--threads", type=int, nargs="+", default=[1])
    parser.add_argument("--learn", action="store_true")
    parser.add_argument("--name", default=None)
    options = parser.parse_args()
    rows = [measure(n, threads, options.learn) for n in options.sizes for threads in options.threads]
    notes = {}
    large = [r for r in rows if r["animals"] >= 9_000 and r["threads"] == options.threads[0]]
    if len(large) > 1:
        x, y = (
            np.log([r["animals"] for r in large]),
            np.log([r["ns per animal per tick"] * r["animals"] for r in large]),
        )
        notes["exponent of the time per tick from 10^4 animals up"] = float(np.polyfit(x, y, 1)[0])
    name = options.name or ("animals_learning" if options.learn else "animals")
    _bench.save(
        name, "Animals that sense, decide and act" + (", with PPO" if options.learn else ""), rows, notes
    )
    print(notes)


if __name__ == "__main__":
    main()
