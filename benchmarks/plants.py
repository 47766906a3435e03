"""Measure plant-steps per second: plants grow, spread and die of old age, with the ledger and the recorder
enabled.

python benchmarks/plants.py [--sizes 10000 100000 1000000]
"""

import argparse
import math
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

from ecs_eco import World


def meadow(plants: int) -> dict:
    """Return a world of plants that grow with light, spread to sites within 10 m, and die of old age."""
    side = 2.0 * math.sqrt(plants / 0.8)
    plant = {
        "count": plants,
        "body": {"radius": 0.4},
        "metabolism": {"energy": 0.1, "energy_max": 1.0, "photosynthesis": 0.002},
        "reproduction": {
            "kind": "spread",
            "rate": 0.01,
            "seed_rain": 0.001,
            "spacing": 2.0,
            "place": "near",
            "dispersal": 10.0,
        },
        "lethal": [{"property": "age", "max": 500.0, "cause_above": "too old"}],
    }
    return {"format": 1, "name": "meadow", "space": {"size": [side, side]}, "species": {"plant": plant}}


def main() -> None:
    """Measure all sizes in turn."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[10_000, 100_000, 1_000_000])
    rows = []
    for n in parser.parse_args().sizes:
        world = World.from_config(meadow(n), seed=1)
        world.run(5)
        ticks = max(4, 2_000_000 // n)
        times = []
        for _ in range(5):
            start = time.perf_counter()
            world.run(ticks)
            times.append((time.perf_counter() - start) / ticks)
        rows.append(
            {
                "plants": world.tables["plant"].n,
                "ns per plant per tick": min(times) / n * 1e9,
                "M plant-steps/s": n / min(times) / 1e6,
            }
        )
    _bench.save("plants", "Plants that grow and spread", rows)


if __name__ == "__main__":
    main()
