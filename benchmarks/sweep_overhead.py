"""Measure the overhead of a sweep: the same runs, alternately bare and as jobs, on the same workers.

    python benchmarks/sweep_overhead.py [--runs 20] [--ticks 1000] [--workers 2] [--on local] [--pairs 3]

Both kinds of runs record to folders; the order within pairs alternates, and workers have compiled kernels.
Bare runs always use local processes.
"""

import argparse
import statistics
import sys
import tempfile
import time
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

from ecs_eco.config import load
from ecs_eco.lab import run_sweep
from ecs_eco.lab.executors import engine
from ecs_eco.lab.folder import read_sweep
from ecs_eco.lab.table import rows_of
from ecs_eco.lab.work import completed

SMALL = {
    "space.size": [120.0, 120.0],
    "species.grass.count": 1080,
    "species.deer.count": 175,
    "species.wolf.count": 20,
}


def bare(config: Any, seed: int, ticks: int, folder: Path) -> str:
    """Run a world and record it to a folder; return its digest."""
    from ecs_eco.record import run_to_folder

    return str(
        run_to_folder(config, seed=seed, ticks=ticks, out=folder, policies="random", report=False)["digest"]
    )


def bare_runs(pool: Executor, place: Path, runs: int, ticks: int) -> list[str]:
    """Run all worlds on the workers; return the digests by seed."""
    config = load("predator-prey", SMALL)
    jobs = {seed: (bare, config, seed, ticks, place / str(seed)) for seed in range(1, runs + 1)}
    done = {seed: future.result() for seed, future in completed(pool, jobs)}
    return [done[seed] for seed in sorted(done)]


def swept(pool: Executor, place: Path, runs: int, ticks: int) -> list[str]:
    """Run all worlds as a sweep; return the digests by seed."""
    plan = {"world": "predator-prey", "set": SMALL, "policies": "random", "ticks": ticks, "world_seeds": runs}
    outcome = run_sweep(plan, place, executor=pool)
    assert outcome.whole, outcome.failed
    return [row["digest"] for row in rows_of(read_sweep(place))]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    for name, default in (("runs", 20), ("ticks", 1000), ("workers", 2), ("pairs", 3)):
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--on", default="local")
    asked = parser.parse_args()
    rows = []
    with (
        engine("local", asked.workers) as local,
        engine(asked.on, asked.workers) as other,
        tempfile.TemporaryDirectory() as place,
    ):
        pools = {bare_runs: local, swept: other}
        for warm, pool in pools.items():
            warm(pool, Path(place) / f"warm-{warm.__name__}", 2 * asked.workers, asked.ticks)
        for pair in range(asked.pairs):
            seconds, digests = {}, {}
            for way in (bare_runs, swept) if pair % 2 == 0 else (swept, bare_runs):
                start = time.perf_counter()
                folder = Path(place) / f"{pair}-{way.__name__}"
                digests[way] = way(pools[way], folder, asked.runs, asked.ticks)
                seconds[way] = time.perf_counter() - start
            rows.append(
                {
                    "pair": pair + 1,
                    "bare [s]": seconds[bare_runs],
                    "sweep [s]": seconds[swept],
                    "overhead": seconds[swept] / seconds[bare_runs] - 1,
                    "same digests": digests[bare_runs] == digests[swept],
                }
            )
    median = statistics.median(row["overhead"] for row in rows)
    _bench.save(
        f"sweep_overhead{'' if asked.on == 'local' else f'_{asked.on}'}",
        f"The overhead of a sweep compared with {asked.runs} bare runs of {asked.ticks:,} ticks",
        rows,
        {
            "median overhead": median,
            "workers": asked.workers,
            "on": asked.on,
            "ticks": asked.ticks,
            "runs": asked.runs,
            "config_hash": load("predator-prey", SMALL).config_hash,
            "seeds": f"1 to {asked.runs}",
        },
    )


if __name__ == "__main__":
    main()
