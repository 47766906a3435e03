"""Compare tick times of this commit and another, run alternately in the world of animals.py.

    python benchmarks/animals_pairs.py --before COMMIT [--rows 10000:2:1:0 …] [--turns 60]

Two processes with the same world take turns running a few ticks, `--turns` times. If COMMIT is this commit
and the rows are `10000:2:1:0`, the table shows the gain from a second thread and, with `--beside 1`, the loss
if the second core has other work. The ratio is this commit's processor time (wall-clock time with several
threads) divided by the other's, turn by turn (median and quartiles). `now / before, quietest turns` is the
ratio between means over the shortest tenth of turns, which other work disturbed least. Times are per animal,
because worlds with different digests diverge after some ticks; `same final state` reports whether they agree.
GiB is the process's peak memory.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench
from before_after import environment

ROOT = Path(__file__).parents[1]
WORLD = """
import json, resource, sys, time
sys.path.insert(0, "benchmarks")
import _bench
_bench.pin_threads()
from ecs_eco import World

animals, threads, learn, ticks = json.loads(sys.argv[1])
world = World.from_config(_bench.savanna(animals), seed=1, policies="untrained", threads=threads,
                          training=True, learn=learn)
world.run(65 if learn else 15)
print("ready", flush=True)
for asked in sys.stdin:
    wall, own = time.perf_counter(), time.process_time()
    world.run(ticks)
    wall, own = time.perf_counter() - wall, time.process_time() - own
    n = world.tables["grazer"].n + world.tables["hunter"].n
    held = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20  # in KiB
    print(json.dumps([wall / ticks / n * 1e9, own / ticks / n * 1e9, held,
                      world.digest() if "d" in asked else ""]), flush=True)
"""


@contextmanager
def beside(processes: int) -> Iterator[None]:
    """Start the given number of processes, each of which keeps a core busy."""
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(processes)]
    try:
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()


def start(place: Path, asked: list[Any]) -> subprocess.Popen[str]:
    """Start a process with the package at a path; return it once its world is ready."""
    made = subprocess.Popen(
        [sys.executable, "-c", WORLD, json.dumps(asked)],
        cwd=place,
        text=True,
        env=environment(place),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert made.stdout is not None
    made.stdout.readline()  # the other process waits until this one is ready
    return made


def turn(process: subprocess.Popen[str], last: bool) -> list[Any]:
    """Run some ticks of a world; return the wall-clock and processor time per animal [ns], the peak memory so
    far [GiB], and the final digest."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write("d\n" if last else "\n")
    process.stdin.flush()
    line: list[Any] = json.loads(process.stdout.readline())
    return line


def measure(before: Path, animals: int, threads: int, others: int, learn: bool, turns: int) -> dict[str, Any]:
    """Return one world's row: this commit on the given number of threads, the other commit on `others`
    threads."""
    # processes are slow after waiting, especially with several threads, so turns are long
    ticks = 64 if learn else max(1, (20_000 if max(threads, others) == 1 else 2_000_000) // animals)
    worlds = [start(before, [animals, others, learn, ticks]), start(ROOT, [animals, threads, learn, ticks])]
    took: list[list[list[Any]]] = [[], []]
    for number in range(turns):
        for which in ((0, 1), (1, 0))[number % 2]:
            took[which].append(turn(worlds[which], number == turns - 1))
    for world in worlds:
        world.kill()
        world.communicate()
    clock = 0 if max(threads, others) > 1 else 1
    ratios = [now[clock] / was[clock] for was, now in zip(*took, strict=True)]
    least = [statistics.mean(sorted(t[clock] for t in one)[: max(1, turns // 10)]) for one in took]
    low, middle, high = statistics.quantiles(ratios, n=4)
    row = {
        "animals": animals,
        "learning": learn,
        "threads": threads,
        "threads before": others,
        "turns": turns,
        "clock": ("wall", "processor")[clock],
        "before, ns per animal per tick": least[0],
        "now, ns per animal per tick": least[1],
        "now / before": middle,
        "quartiles": f"{low:.3f}-{high:.3f}",
        "now / before, quietest turns": least[1] / least[0],
        "GiB before": took[0][-1][2],
        "GiB now": took[1][-1][2],
        "same final state": took[0][-1][3] == took[1][-1][3],
    }
    return row


def main() -> None:
    """Measure the requested rows."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--before", metavar="COMMIT", required=True)
    parser.add_argument(
        "--rows",
        nargs="+",
        metavar="ANIMALS:THREADS:BEFORE:LEARN",
        default=["1000:1:1:0", "10000:1:1:0", "100000:1:1:0", "10000:1:1:1", "10000:2:2:0", "100000:2:2:0"],
    )
    parser.add_argument("--folder", type=Path, help="a checkout of that commit with compiled kernels")
    parser.add_argument("--turns", type=int, default=60)
    parser.add_argument(
        "--beside", type=int, default=0, help="processes that each keep a core busy during the measurement"
    )
    parser.add_argument("--name", default="animals_pairs", help="name of the result")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        before, rows = Path(folder), []
        if given.folder is not None:
            before = given.folder
        else:
            files = subprocess.run(
                ["git", "archive", given.before], cwd=ROOT, capture_output=True, check=True
            ).stdout
            subprocess.run(["tar", "x", "-C", folder], input=files, check=True)
        for words in given.rows:
            animals, threads, others, learn = map(int, words.split(":"))
            turns = max(4, given.turns // 8) if learn else given.turns
            with beside(given.beside):
                row = measure(before, animals, threads, others, bool(learn), turns)
            rows.append(row | ({"busy processes": given.beside} if given.beside else {}))
            _bench.save(
                given.name,
                "Animals that sense, decide and act, against an earlier commit",
                rows,
                {"before": given.before},
            )


if __name__ == "__main__":
    main()
