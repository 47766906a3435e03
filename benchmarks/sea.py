"""Measure plankton-steps per second in one sea: the world diel-migration with a wider surface, active
policies, and the ledger and the recorder enabled.

    python benchmarks/sea.py [--sizes 1000 10000 100000]
    python benchmarks/sea.py --life        # the shipped world: training from random weights, 20 days to disk
"""

import argparse
import math
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

from ecs_eco import World
from ecs_eco.config import WorldConfig, load


def sea(plankton: int) -> WorldConfig:
    """Return the sea, wide enough to hold this initial number of phytoplankton, copepods and krill at their
    original density."""
    shipped = load("diel-migration")
    now = {name: s.count for name, s in shipped.species.items()}
    factor = plankton / sum(now.values())
    side = round(math.sqrt(shipped.space.size[0] * shipped.space.size[1] * factor), 1)
    numbers: dict[str, object] = {
        f"species.{name}.count": max(1, round(n * factor)) for name, n in now.items()
    }
    numbers |= {
        f"species.{n}.max_count": math.ceil(s.max_count * factor)
        for n, s in shipped.species.items()
        if s.max_count
    }
    return load(shipped, numbers | {"space.size": [side, side, shipped.space.size[2]]})


def lifetime() -> None:
    """Time training from random weights and the subsequent run, once each, with compiled kernels."""
    from ecs_eco.lab.pretraining import pretrain
    from ecs_eco.record import run_to_folder

    config = load("diel-migration")
    with tempfile.TemporaryDirectory() as scratch:
        pretrain(config, seed=2, ticks=20, out=f"{scratch}/warm")
        run_to_folder(config, 2, 20, f"{scratch}/warm-run", report=False)
        start = time.perf_counter()
        pretrain(config, seed=1, out=f"{scratch}/policies")
        trained = time.perf_counter()
        run_to_folder(config, 1, config.ticks, f"{scratch}/run", report=False)
        lived = time.perf_counter()
    rows = [
        {
            "what": "training from random weights",
            "ticks": config.training.ticks,
            "s": trained - start,
            "goal [s]": 900,
        },
        {
            "what": "20 days with the bundled policies, recorded",
            "ticks": config.ticks,
            "s": lived - trained,
            "goal [s]": 120,
        },
    ]
    _bench.save("sea_life", "The shipped sea, on one thread", rows)


def main() -> None:
    """Measure all sizes in turn, starting at noon."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[1000, 10_000, 100_000])
    parser.add_argument("--life", action="store_true", help="time the shipped world instead")
    asked = parser.parse_args()
    if asked.life:
        return lifetime()
    rows = []
    for n in asked.sizes:
        config = sea(n)
        world = World.from_config(config, seed=1, policies="untrained", learn=False)
        world.run(5)
        ticks = max(4, 200_000 // n)
        times, lived = [], []
        for _ in range(5):
            alive, start = sum(t.n for t in world.tables.values()), time.perf_counter()
            world.run(ticks)
            times.append((time.perf_counter() - start) / ticks)
            lived.append(alive)
        best = times.index(min(times))
        rows.append(
            {
                "plankton": lived[best],
                "that decide": sum(t.n for name, t in world.tables.items() if name != "phytoplankton"),
                "ticks/s": 1 / min(times),
                "M plankton-steps/s": lived[best] / min(times) / 1e6,
            }
        )
    _bench.save(
        "sea",
        "Plankton in one sea with shade, three-dimensional senses, policies, grazing and births, on one core",
        rows,
    )


if __name__ == "__main__":
    main()
