"""Measure the README's main job, `ecs-eco run predator-prey --seed 1`, with frozen policies: 10,000 ticks, and
the Python calls per tick.

    python benchmarks/main_job.py [--before COMMIT] [--ticks 10000] [--pairs 3]
    python benchmarks/main_job.py --learn [--ticks 10000] [--pairs 3]
    python benchmarks/main_job.py --train [--before COMMIT] [--ticks 3000] [--pairs 3]
    python benchmarks/main_job.py --calls
    python benchmarks/main_job.py --between

Processes with this commit and, if given, another commit take turns; each records its own world on disk. The
table shows the wall-clock and processor seconds that `World.run` takes, excluding the process's start.
`Python calls per tick` counts the Python functions and kernels called in ticks 1,001 to 1,070, excluding the
calls of `run`. `end` describes the final state, which differs if digests differ. `--learn` compares frozen
policies with policies that learn, the world's default. `--train` measures in the same way how long
predator-prey policies take to learn from random weights. `--calls` measures how the cost of a kernel call
depends on its number of arrays. `--between` measures how much of a tick passes between kernels.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import before_after

ROOT = Path(__file__).parents[1]
LEARNING = "learning"
LARGE = {
    "space.size": [640.0, 640.0],
    "species.grass.count": 25_000,
    "species.deer.count": 9000,
    "species.wolf.count": 1000,
}
JOB = """
import json, sys, tempfile, time
from ecs_eco import World
from ecs_eco.config import load

ticks, counted, learn = json.loads(sys.argv[1])
with tempfile.TemporaryDirectory() as folder:
    world = World.from_config(load("predator-prey"), seed=1, learn=learn, record=folder + "/run")
    world.run(20)  # reads the kernels
    calls = [0]

    def count(frame, event, argument):
        calls[0] += event == "call"

    def calls_of(n):
        calls[0] = 0
        sys.setprofile(count)
        world.run(n)
        sys.setprofile(None)
        return calls[0]

    if counted:
        world.run(1000 - world.tick)
        few, many = calls_of(10), calls_of(60)
        print(json.dumps([(many - few) / 50, str(world)]))
    else:
        wall, own = time.perf_counter(), time.process_time()
        world.run(ticks - world.tick)
        print(json.dumps([time.perf_counter() - wall, time.process_time() - own, str(world), world.digest()]))
"""
TRAINING = """
import hashlib, json, sys, time
from ecs_eco.lab.pretraining import pretrain

ticks = json.loads(sys.argv[1])[0]
pretrain("predator-prey", 1, 130)  # reads the kernels
wall, own = time.perf_counter(), time.process_time()
learned = pretrain("predator-prey", 1, ticks)["policies"]
took = time.perf_counter() - wall, time.process_time() - own
weights = [array.tobytes() for _, state in sorted(learned.items()) for _, array in sorted(state.items())]
print(json.dumps([*took, hashlib.sha256(b"".join(weights)).hexdigest()]))
"""


def pairs(places: dict[str, Path], ticks: int, n: int, train: bool) -> list[dict[str, Any]]:
    """Return a row for each commit, or for frozen and learning policies: the seconds of n alternating runs, their medians, and the final state."""
    took: dict[str, list[list[float]]] = {name: [] for name in places}
    ends = {}
    for number in range(n):
        order = list(places) if number % 2 else list(reversed(places))
        for name in order:
            wall, own, *ends[name] = before_after.call(
                places[name], TRAINING if train else JOB, [ticks, False, name == LEARNING]
            )
            took[name].append([wall, own])
            print(name, round(wall, 2), round(own, 2), ends[name], flush=True)
    first = next(iter(places))
    rows = []
    for name, place in places.items():
        ratios = [own[1] / other[1] for own, other in zip(took[name], took[first], strict=True)]
        rows.append(
            {
                "run" if LEARNING in places else "commit": name,
                "ticks": ticks,
                "pairs": n,
                "wall [s]": statistics.median(t[0] for t in took[name]),
                "processor [s]": statistics.median(t[1] for t in took[name]),
                "times as long as the first": statistics.median(ratios),
                "from": min(ratios),
                "to": max(ratios),
                "end": ends[name][0],
            }
        )
        if not train:
            rows[-1]["Python calls per tick"], _ = before_after.call(
                place, JOB, [ticks, True, name == LEARNING]
            )
    return rows


def call_of(n: int) -> dict[str, Any]:
    """Return the duration of a call to an empty kernel with n arrays."""
    import numba
    import numpy as np

    names = ", ".join(f"a{i}" for i in range(n))
    room: dict[str, Any] = {}
    exec(f"def kernel({names}):\n    return a0.size", room)
    kernel = numba.njit(nogil=True, error_model="numpy")(room["kernel"])
    arrays = [np.zeros(10, np.float32) for _ in range(n)]
    took = []
    for _ in range(400):
        start = time.process_time()
        for _ in range(500):
            kernel(*arrays)
        took.append(time.process_time() - start)
    return {"arrays": n, "µs per call": min(took) / 500 * 1e6}


def between(animals: str, settings: dict[str, Any], ticks: int, part: int, rounds: int = 5) -> dict[str, Any]:
    """Return the processor time of a tick, and how much of it passes between the kernels that Python calls.
    Two equal worlds take turns; only the second one's kernels are timed, and the shortest of several rounds
    counts."""
    from ecs_eco import World
    from ecs_eco.compiled.kernel import Kernel
    from ecs_eco.config import load

    direct, clock, spent, calls = Kernel.__call__, time.thread_time_ns, [0], [0]

    def timed(kernel: Any, *arguments: Any) -> Any:
        begin = clock()
        result = direct(kernel, *arguments)
        spent[0] += clock() - begin
        calls[0] += 1
        return result

    wholes, insides = [], []
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as folder:
            worlds = [
                World.from_config(
                    load("predator-prey", settings), seed=1, learn=False, record=f"{folder}/{k}"
                )
                for k in range(2)
            ]
            whole, inside, calls[0] = [], [], 0
            for world in worlds:
                world.run(20)  # reads the kernels
            for _ in range(ticks // part):
                begin = clock()
                worlds[0].run(part)
                whole.append(clock() - begin)
                spent[0], Kernel.__call__ = 0, timed  # type: ignore[method-assign]
                worlds[1].run(part)
                del Kernel.__call__
                inside.append(spent[0])
        wholes.append(whole)
        insides.append(inside)
    whole_ns, inside_ns = (sum(map(min, zip(*some, strict=True))) / ticks for some in (wholes, insides))
    return {
        "animals": animals,
        "µs per tick": whole_ns / 1e3,
        "kernel calls per tick": calls[0] / ticks,
        "µs in kernels": inside_ns / 1e3,
        "share between kernels": 1 - inside_ns / whole_ns,
    }


def main() -> None:
    """Measure this commit and, if given, another."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--calls", action="store_true", help="measure only the cost of calling a kernel")
    parser.add_argument("--between", action="store_true", help="measure only the time between kernels")
    parser.add_argument("--before", metavar="COMMIT")
    parser.add_argument("--learn", action="store_true", help="compare frozen and learning policies")
    parser.add_argument("--train", action="store_true", help="measure learning from random weights")
    parser.add_argument("--ticks", type=int)
    parser.add_argument("--pairs", type=int, default=3)
    given = parser.parse_args()
    if given.calls:
        rows = [call_of(n) for n in (1, 5, 10, 20, 30)]
        _bench.save("main_job_calls", "The cost of a kernel call, by number of arrays", rows)
        return
    if given.between:
        rows = [between("1,000", {}, 200, 10), between("10,000", LARGE, 30, 2)]
        _bench.save("main_job_between", "How much of a tick passes between kernels", rows)
        return
    with tempfile.TemporaryDirectory() as folder:
        places = {}
        if given.before is not None:
            files = subprocess.run(
                ["git", "archive", given.before], cwd=ROOT, capture_output=True, check=True
            ).stdout
            subprocess.run(["tar", "x", "-C", folder], input=files, check=True)
            places[given.before] = Path(folder)
        places |= {"frozen": ROOT, LEARNING: ROOT} if given.learn else {"this": ROOT}
        rows = pairs(places, given.ticks or (3000 if given.train else 10_000), given.pairs, given.train)
    question = (
        "Training predator-prey policies from random weights, on one core"
        if given.train
        else "README's main job, predator-prey recorded on one core: frozen and learning policies"
        if given.learn
        else "README's main job with frozen policies: predator-prey, recorded, on one core"
    )
    _bench.save(
        "main_job_training" if given.train else "main_job_learning" if given.learn else "main_job",
        question,
        rows,
        {"load before the benchmark": round(os.getloadavg()[0], 2)},
    )


if __name__ == "__main__":
    main()
