"""Compare this commit with another by alternately running jobs from other benchmarks.

    python benchmarks/in_turns.py --before COMMIT [--folder CHECKOUT] [--turns 9]
        [--cases learners wolves memory]

`learners`: individual_ppo.py, 1,000 animals with a network each, on two threads. `wolves`: wolf_sheep.py
without Mesa, at all of its sizes. `memory`: memory.py, after a request for all of esper's ids. One process
waits while the other works; each runs its own commit's script. `before` and `now` are medians over turns, and
`best` is the minimum or maximum; the ratio is this commit's figure divided by the other's, turn by turn:
median and quartiles.
"""

import argparse
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench
from before_after import environment

ROOT = Path(__file__).parents[1]
BEGIN = """
import sys, time
sys.path.insert(0, "benchmarks")
import _bench
_bench.pin_threads()
"""
LEARNERS = """
import individual_ppo as bench
herd, horizon = bench.Herd(1000, 24, (32,), 8, 2), bench.SETTINGS.horizon
for _ in range(2 * horizon):
    herd.live()
for _ in sys.stdin:
    begin = time.perf_counter()
    for _ in range(horizon):
        herd.live()
    print(horizon / (time.perf_counter() - begin), flush=True)
"""
WOLVES = """
import wolf_sheep_model as model
def seconds(seed):
    world, _ = model.build(WIDTH, seed, model.DEFAULT)
    world.flush()
    begin = time.process_time()
    world.run(60)
    return time.process_time() - begin
seconds(0)
for seed, _ in enumerate(sys.stdin, 1):
    spent = [seconds(seed) for _ in range(RUNS)]
    print(sorted(spent)[len(spent) // 2] / 60 * 1e6, flush=True)
"""
MEMORY = """
import gc, resource
from pathlib import Path
from ecs_eco import World
def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()
World.from_config(_bench.savanna(1000, plants_per_animal=0.01), seed=1, policies="untrained", training=True,
                  learn=True).run(3)
gc.collect()
begin = resident()
world = World.from_config(_bench.savanna(100_000, plants_per_animal=0.01), seed=1, policies="untrained",
                          training=True)
world.run(3)
with world:
    world.sync()
    gc.collect()
    for _ in sys.stdin:
        print((resident() - begin) / 100_000, flush=True)
"""
# case: quantity, unit, whether more is better, code, maximum number of turns
CASES: dict[str, list[tuple[str, str, bool, str, int]]] = {
    "learners": [("1,000 individual learners, two threads", "ticks/s", True, LEARNERS, 99)],
    "wolves": [
        (
            f"wolf-sheep at {width}²",
            "µs per tick",
            False,
            WOLVES.replace("WIDTH", str(width)).replace("RUNS", str(runs)),
            99,
        )
        for width, runs in ((20, 15), (100, 5), (300, 1))
    ],
    "memory": [("100,000 animals with esper ids", "B/animal", False, MEMORY, 1)],
}


def start(place: Path, code: str) -> subprocess.Popen[str]:
    """Return a process that uses the package and benchmarks at a path and works once for each input line."""
    return subprocess.Popen(
        [sys.executable, "-c", BEGIN + code],
        cwd=place,
        text=True,
        env=environment(place),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )


def turn(process: subprocess.Popen[str]) -> float:
    """Make one process work once; return its figure."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write("\n")
    process.stdin.flush()
    return float(process.stdout.readline())


def measure(before: Path, work: str, unit: str, more: bool, code: str, turns: int) -> dict[str, Any]:
    """Return one case's row."""
    both = [start(before, code), start(ROOT, code)]
    took: list[list[float]] = [[], []]
    for number in range(turns):
        for which in ((0, 1), (1, 0))[number % 2]:
            took[which].append(turn(both[which]))
    for process in both:
        process.kill()
        process.communicate()
    ratios = [now / was for was, now in zip(*took, strict=True)]
    low, middle, high = statistics.quantiles(ratios, n=4) if turns > 1 else ratios * 3
    best = max if more else min
    return {
        "work": work,
        "unit": unit,
        "turns": turns,
        "before": statistics.median(took[0]),
        "now": statistics.median(took[1]),
        "now / before": middle,
        "quartiles": f"{low:.3f}-{high:.3f}",
        "best before": best(took[0]),
        "best now": best(took[1]),
    }


def main() -> None:
    """Measure the requested cases."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--before", metavar="COMMIT", required=True)
    parser.add_argument("--folder", type=Path, help="a checkout of that commit with compiled kernels")
    parser.add_argument("--turns", type=int, default=9)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        before, rows = given.folder or Path(folder), []
        if given.folder is None:
            files = subprocess.run(
                ["git", "archive", given.before], cwd=ROOT, capture_output=True, check=True
            ).stdout
            subprocess.run(["tar", "x", "-C", folder], input=files, check=True)
        for work, unit, more, code, most in (one for case in given.cases for one in CASES[case]):
            rows.append(measure(before, work, unit, more, code, min(given.turns, most)))
            _bench.save(
                "in_turns",
                "Work of other benchmarks, against an earlier commit",
                rows,
                {"before": given.before},
            )


if __name__ == "__main__":
    main()
