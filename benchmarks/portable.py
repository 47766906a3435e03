"""Measure the cost of portable mode: each shipped world runs alternately in both modes, in separate
processes.

    python benchmarks/portable.py [--worlds reflexes lamb] [--pairs 3]

A ratio is the median over pairs of consecutive processes. Learners learn every 16 ticks.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()
TICKS, WARM, HORIZON, SEED = 64, 32, 16, 1
CHILD = """
import sys, time
import ecs_eco
from ecs_eco.testing.self_test import Case, short_world
world = short_world(Case(sys.argv[1], sys.argv[2] == "learning"), int(sys.argv[3]), int(sys.argv[4]))
world.run(int(sys.argv[5]))
start = time.process_time()
world.run(int(sys.argv[6]))
print(time.process_time() - start)
"""


def seconds(world: str, learn: bool, portable: bool) -> float:
    """Return the processor time [s] of TICKS ticks in a separate process, after kernels are compiled."""
    words = [world, "learning" if learn else "not", *map(str, (SEED, HORIZON, WARM, TICKS))]
    done = subprocess.run(
        [sys.executable, "-c", CHILD, *words],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "ECS_ECO_PORTABLE": "1" if portable else "0"},
    )
    return float(done.stdout)


def main() -> None:
    """Time the pairs and write the table."""
    from ecs_eco.config.shipped import shipped

    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--worlds", nargs="+", choices=sorted(shipped()), default=sorted(shipped()))
    parser.add_argument("--pairs", type=int, default=3)
    asked = parser.parse_args()
    rows = []
    for world in asked.worlds:
        for learn in (False, True):
            seconds(world, learn, True)  # compile
            seconds(world, learn, False)
            pairs = [(seconds(world, learn, False), seconds(world, learn, True)) for _ in range(asked.pairs)]
            rows.append(
                {
                    "world": world,
                    "learning": learn,
                    "native [ms/tick]": 1e3 * min(native for native, _ in pairs) / TICKS,
                    "portable [ms/tick]": 1e3 * min(portable for _, portable in pairs) / TICKS,
                    "ratio": statistics.median(portable / native for native, portable in pairs),
                }
            )
            print(json.dumps(rows[-1]), flush=True)
    _bench.save(
        "portable",
        "Portable mode against native mode",
        rows,
        {
            "ticks": TICKS,
            "initial ticks, not timed": WARM,
            "horizon": HORIZON,
            "pairs": asked.pairs,
            "seed": SEED,
            "median ratio": statistics.median(row["ratio"] for row in rows),
        },
    )


if __name__ == "__main__":
    main()
