"""Measure the gain from each trick in `ecs_eco.compiled`: the same jobs run alternately with all tricks and
with all but one.

    python benchmarks/ablations.py [--pairs 7] [--firsts 3] [--at-once 1] [--tricks NAME …]

A trick is switched off by code that runs before the package is loaded, in processes with a separate kernel
folder if the trick changes kernels. In each turn, every variant runs every job once, in a different order.
The table shows how many times as long a job takes without the trick: the median over turns and the range.
Jobs: README's predator-prey, 1,000 ticks recorded; 40 ticks of 10,000 animals, on one thread and on two; a
later start of `ecs-eco run` with 100 ticks; and in some turns a first start, which compiles with one process.
Times are processor seconds, which other work on the machine disturbs less; for two threads, they are
wall-clock seconds. Tricks that concern only threads are the control for jobs on one thread: deviations from 1
in their rows are noise. The lines below the table name variants whose results differ.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

ROOT = Path(__file__).parents[1]
ALL = "all tricks"
PLAIN = "all tricks that need numba's private names"
FORM = "a form for calls from kernels, without machine code"
PREFETCHING = "prefetching"
TWO = "(with: two processes at the first start)"
TRICKS = {
    "arrays borrowed, not owned, by calls from Python": """
from numba.core.lowering import Lower
from ecs_eco.compiled import numba_private
numba_private.OuterLowering.lowering_class = property(lambda self: Lower)
numba_private.InnerLowering.lowering_class = property(lambda self: Lower)
""",
    FORM: """
from ecs_eco.compiled import kernel
make = kernel.kernel
def of_one_form(function, **options):
    made = make(function, **options)
    made.inner = made
    return made
kernel.kernel = of_one_form
""",
    "kernels loaded without numba's compiler": """
from functools import cache
from numba.core.registry import cpu_target
from ecs_eco.compiled import numba_private
numba_private._provide_runtime = cache(lambda: cpu_target.target_context.refresh())
""",
    "environments without constants left out": """
from ecs_eco.compiled import numba_private
numba_private._is_bare = lambda environment: False
""",
    "noalias": """
from ecs_eco.compiled import kernel
kept = kernel.kept_kernel
kernel.kept_kernel = lambda function, folder, fastmath=False, noalias=False: kept(function, folder, fastmath)
""",
    PREFETCHING: """
from ecs_eco.compiled import vectors
from ecs_eco.compiled.jit import njit
@njit
def prefetch(array, at):
    pass
vectors.prefetch = prefetch
""",
    "kernels divided between threads without the GIL": """
from ecs_eco.compiled.team import Team
Team.divides = lambda self, kernel: False
""",
    "threads that stay awake": """
from ecs_eco.compiled import helpers, team
helpers.AWAKE = team.AWAKE = 0.0
""",
    "work divided only if that takes less time": """
from ecs_eco.compiled.pace import Pace
Pace.divide = lambda self: True
""",
    "garbage collected seldom while modules load": """
from contextlib import nullcontext
from ecs_eco.compiled import garbage
garbage.uncollected = garbage.of_a_command = nullcontext
""",
    PLAIN: "",
}
LIFE = """
import json, sys, tempfile, time
from ecs_eco import World
from ecs_eco.config import load

def took(world, ticks):
    wall, own = time.perf_counter(), time.process_time()
    world.run(ticks)
    return time.perf_counter() - wall, time.process_time() - own

with tempfile.TemporaryDirectory() as folder:
    world = World.from_config(load("predator-prey"), seed=1, learn=False, record=folder + "/run").run(20)
    out, ends = {"1,000 ticks": took(world, 980)[1]}, [world.digest()]
large = {"space.size": [640.0, 640.0], "species.grass.count": 25_000, "species.deer.count": 9000,
         "species.wolf.count": 1000}
if sys.argv[1:]:
    own = {f"species.{name}.{key}": value for name in ("deer", "wolf")
           for key, value in {"policy.kind": "individual", "count": 300}.items()}
    world = World.from_config(load("predator-prey", own), seed=1, learn=True, policies="untrained", record=False)
    out["40 ticks of 600 that learn alone"] = took(world.run(20), 40)[1]
    ends.append(world.digest())
for threads, clock, name in ((1, 1, "40 ticks of 10,000"), (2, 0, "40 ticks of 10,000, two threads")):
    world = World.from_config(load("predator-prey", large), seed=1, learn=False, threads=threads, record=False).run(20)
    out[name] = took(world, 40)[clock]
    ends.append(world.digest())
print(json.dumps([out, ends]))
"""
START = """
from ecs_eco.cli import main
main()
"""
SAME_KERNELS = (
    "kernels loaded without numba's compiler",
    "kernels divided between threads without the GIL",
    "threads that stay awake",
    "work divided only if that takes less time",
)
"""Tricks that affect neither kernels nor a first start."""
FIRST_START = TWO, FORM
"""Tricks that matter only at a first start: without this form, cached machine code cannot be linked into
kernels."""
ONE_PROCESS = """
from ecs_eco.worlds import first_start
first_start.cores = lambda: 1
"""


def process(trick: str, cache: Path, code: str, *arguments: str) -> tuple[str, float, float]:
    """Run a job without a trick; return its output, wall-clock seconds and processor seconds."""
    environment = os.environ | {
        "ECS_ECO_CACHE": str(cache),
        "PYTHONPATH": str(ROOT),
        "ECS_ECO_PLAIN_NUMBA": "1" if trick == PLAIN else "0",
    }
    begin = time.perf_counter()
    command = [sys.executable, "-c", TRICKS.get(trick, "") + code, *arguments]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE) as job:
        assert job.stdout is not None
        printed = job.stdout.read().decode()
        _, status, used = os.wait4(job.pid, 0)
        job.returncode = os.waitstatus_to_exitcode(status)
    if job.returncode:
        raise RuntimeError(f"without {trick!r}: exit status {job.returncode}")
    return printed, time.perf_counter() - begin, used.ru_utime + used.ru_stime


def start(trick: str, cache: Path, folder: Path, code: str = START) -> tuple[float, float]:
    """Return the wall-clock and processor seconds of a complete command."""
    with tempfile.TemporaryDirectory(dir=folder) as out:
        run = ("run", "predator-prey", "--ticks", "100", "--seed", "1", "--quiet", "--no-report")
        return process(trick, cache, code, *run, "--out", f"{out}/run")[1:]


def turn(
    trick: str, caches: Path, first: bool, learners: Sequence[str]
) -> tuple[dict[str, float], list[str]]:
    """Run every job once without a trick; return the seconds by job and the digests. Individual learners,
    which take a long time to compile, are a job only for the `learners`."""
    cache, out = caches / (ALL if trick in SAME_KERNELS else trick), {}
    if first and trick not in SAME_KERNELS:
        with tempfile.TemporaryDirectory(dir=caches) as empty:
            one = "" if trick == TWO else ONE_PROCESS
            wall, own = start(trick, Path(empty) if cache.exists() else cache, caches, one + START)
            out = {"first start": own, "first start, wall time": wall}
    if trick in FIRST_START:
        return out, []
    printed, _, _ = process(trick, cache, LIFE, *["learn"] * (trick in learners))
    jobs, ends = json.loads(printed.splitlines()[-1])
    return jobs | {"later start": start(trick, cache, caches)[1]} | out, ends


def table(took: dict[str, list[dict[str, float]]]) -> list[dict[str, Any]]:
    """Return a row for each trick: how many times as long each job takes without it."""
    rows = []
    for trick, turns in took.items():
        row: dict[str, Any] = {"without": trick}
        for job in [*took[ALL][-1], *(job for job in took[ALL][0] if job not in took[ALL][-1])]:
            pairs = [(b[job], a[job]) for a, b in zip(took[ALL], turns, strict=True) if job in a and job in b]
            if not pairs:
                row[job] = "–"
            elif trick == ALL:
                row[job] = f"{statistics.median(b for b, _ in pairs):.3g} s"
            else:
                ratios = [b / a for b, a in pairs]
                row[job] = f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"
        rows.append(row)
    return rows


def main() -> None:
    """Measure all variants in turn."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--pairs", type=int, default=7, help="turns, after one that compiles")
    parser.add_argument("--firsts", type=int, default=3, help="turns that also include a first start")
    parser.add_argument("--at-once", type=int, default=1, help="processes that compile in the first turn")
    parser.add_argument("--tricks", nargs="*", choices=[*TRICKS, TWO], default=[*TRICKS, TWO])
    options = parser.parse_args()
    variants = [ALL, *options.tricks]
    took: dict[str, list[dict[str, float]]] = {variant: [] for variant in variants}
    ends: dict[str, list[str]] = {}
    learners = [ALL, PREFETCHING] if PREFETCHING in variants else []
    with tempfile.TemporaryDirectory() as folder:

        def each(some: Sequence[str], number: int, at_once: int = 1) -> None:
            """Run one turn for some variants."""
            with ThreadPoolExecutor(at_once) as pool:
                done = pool.map(lambda one: turn(one, Path(folder), number < options.firsts, learners), some)
                for variant, (seconds, digests) in zip(some, done, strict=True):
                    if number == 0:  # some variants have just compiled, which also warms up their processes
                        seconds = {job: seconds[job] for job in seconds if job.startswith("first")}
                    took[variant].append(seconds)
                    ends[variant] = digests
                    print(number, variant, {job: round(s, 2) for job, s in seconds.items()}, flush=True)

        each([one for one in variants if one not in SAME_KERNELS], 0, options.at_once)
        each([one for one in variants if one in SAME_KERNELS], 0)
        for number in range(1, options.pairs + 1):
            each(variants[::-1] if number % 2 else variants, number)
    other = [one for one in variants if ends[one] and not set(ends[one]) <= set(ends[ALL])]
    _bench.save(
        "ablations",
        "Jobs without one trick: how many times as long they take",
        table(took),
        {
            "turns": options.pairs,
            "turns with a first start": options.firsts,
            "variants with a different digest": ", ".join(other) or "none",
            "machine": f"{'busy' if os.getloadavg()[2] > (os.cpu_count() or 1) else 'idle'} during the measurement",
        },
    )


if __name__ == "__main__":
    main()
