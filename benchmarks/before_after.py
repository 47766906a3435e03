"""Compare another commit with this one: are the results the same, and how fast is each?

    python benchmarks/before_after.py digests --before COMMIT
    python benchmarks/before_after.py times --before COMMIT [--sets 8] [--worlds NAME …]
    python benchmarks/before_after.py systems --before COMMIT [--worlds NAME …]
    python benchmarks/before_after.py starts --before COMMIT [--pairs 12] [--firsts 3]

`digests`: for ten runs of 500 ticks, covering all shipped worlds, learning on and off, and shared and
individual policies, a hash of all organisms' positions, contents and identities. `times`: processes with
compiled kernels build a world and take turns running a few ticks; only one works at a time. Turns with the
same number have the same seed and therefore the same organisms, even if the last bits of policies differ. The
ratio is this commit's seconds divided by the other's. A second process with the other commit is the control:
its ratio deviates from 1 because processes differ in memory layout. All processes are restarted after every
few turns, and the 95% interval is bootstrapped over these sets of processes. `systems`: each system's time
per tick [µs], which is the shortest time of each tick among worlds with the same seeds, run alternately by
processes of both commits. Noise only adds time, so this comparison resolves differences that `times` cannot.
`starts`: complete processes of both commits, run alternately, without and with their report, and with an
empty cache. Results are written to benchmarks/results/before_after_<what>.json.
"""

import argparse
import compileall
import json
import os
import random
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "benchmarks" / "results"
TICKS, TURNS = 500, 9
CASES = [
    (world, learn, {})
    for world in ("predator-prey", "reflexes", "learning-krill", "happiness")
    for learn in (False, True)
]
CASES += [("diel-migration", False, {}), ("lamb", True, {})]
CASES[1] = (
    "predator-prey",
    True,
    {
        "species.deer.policy.kind": "individual",
        "species.wolf.policy.kind": "individual",
        "species.deer.count": 300,
        "species.wolf.count": 40,
    },
)
FROZEN = {f"species.{name}.policy.learn": False for name in ("deer", "wolf")}
WORLDS: dict[str, tuple[str, dict[str, Any], int]] = {  # world, changes, ticks per turn of one run
    "predator-prey": ("predator-prey", FROZEN, 40),
    "predator-prey, 10,000 animals": (
        "predator-prey",
        FROZEN
        | {
            "space.size": [640.0, 640.0],
            "species.grass.count": 25_000,
            "species.deer.count": 9000,
            "species.wolf.count": 1000,
        },
        12,
    ),
    **{
        name: (name, {}, 40)
        for name in ("reflexes", "happiness", "innate", "island", "diel-migration", "learning-krill", "lamb")
    },
}

DIGEST = """
import hashlib, json, sys
import numpy as np
from ecs_eco import World
from ecs_eco.components import Body, Genome, Metabolism, Position
from ecs_eco.config import load

name, learn, changes, ticks = json.loads(sys.argv[1])
policies = "untrained" if changes else "trained"
world = World.from_config(load(name, changes), seed=1, learn=learn, policies=policies, record=False)
world.run(ticks)
digest = hashlib.sha256()
for table in world.tables.values():
    rows = table.by_uid()
    digest.update(table.uid[rows].tobytes() + table.born[rows].tobytes())
    for component in (Position, Body, Metabolism, Genome):
        if component in table:
            for field, column in sorted(vars(table[component]).items()):
                digest.update(np.ascontiguousarray(column[rows]).tobytes())
print(json.dumps([digest.hexdigest(), {n: t.n for n, t in world.tables.items()}]))
"""
TIME = """
import gc, json, sys, time
from ecs_eco import World
from ecs_eco.config import load

name, changes, ticks, one = json.loads(sys.argv[1])
for turn, _ in enumerate(sys.stdin):
    world = World.from_config(load(name, changes), seed=turn, record=False).run(5)
    gc.collect()
    start = time.perf_counter()
    if one:
        for _ in range(ticks):
            world.run(1)
    else:
        world.run(ticks)
    print(time.perf_counter() - start, flush=True)
    del world
"""

SYSTEMS = """
import collections, json, sys, time
from ecs_eco import World
from ecs_eco.config import load

name, changes, ticks = json.loads(sys.argv[1])


def timed(process, took):
    def call():
        start = time.perf_counter()
        process()
        took.append(time.perf_counter() - start)

    return call


for turn, _ in enumerate(sys.stdin):
    took = collections.defaultdict(list)
    world = World.from_config(load(name, changes), seed=turn, record=False).run(5)
    for system in world.systems:
        system.process = timed(system.process, took[type(system).__name__])
    whole = timed(lambda: world.run(1), took["whole tick"])
    for _ in range(ticks):
        whole()
    print(json.dumps(took), flush=True)
"""


START = """
import json, sys
from ecs_eco.cli import main

try:
    main()
except SystemExit as end:
    if end.code:
        raise
heavy = ("torch", "pandas", "matplotlib", "scipy.stats", "scipy.linalg", "pyarrow", "pydantic")
print(json.dumps({"modules": len(sys.modules), "of these": [name for name in heavy if name in sys.modules]}))
"""


def environment(place: Path) -> dict[str, str]:
    """Return the environment for a process that imports the package at a commit, with bytecode cached as on a
    user's machine."""
    return {k: v for k, v in os.environ.items() if k not in ("ECS_ECO_DEBUG", "PYTHONDONTWRITEBYTECODE")} | {
        "PYTHONPATH": str(place)
    }


def call(place: Path, code: str, argument: Any) -> Any:
    """Return the JSON output of code run in a process that imports the package at a commit."""
    command = [sys.executable, "-c", code, json.dumps(argument)]
    done = subprocess.run(
        command, cwd=place, env=environment(place), capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(done.stderr[-2000:])
    return json.loads(done.stdout.splitlines()[-1])


def digests(before: Path) -> dict[str, Any]:
    """Return, for each case, whether both commits end with the same digest."""
    cases = []
    for name, learn, changes in CASES:
        asked = [name, learn, changes, TICKS]
        was, now = (call(place, DIGEST, asked) for place in (before, ROOT))
        cases.append(
            {
                "world": name,
                "learning": learn,
                "changes": changes,
                "equal": was == now,
                "digest": now[0],
                "living": now[1],
            }
        )
        print(json.dumps(cases[-1]), flush=True)
    return {"cases": cases, "equal": sum(case["equal"] for case in cases)}


def times(before: Path, sets: int, worlds: list[str]) -> dict[str, Any]:
    """Return, for each of these worlds, this commit's seconds divided by the other's, and the control's
    ratio."""
    results = {}
    for name in worlds:
        world, changes, ticks = WORLDS[name]
        for one, turn_ticks in ((False, ticks), (True, ticks // 4)):
            took: list[list[list[float]]] = []  # by set, turn and process
            for _ in range(sets):
                with living([before, before, ROOT], [world, changes, turn_ticks, one]) as turn:
                    # the first two turns compile
                    took.append([turn(number) for number in range(2 + TURNS)][2:])
            key = f"{name}, {'run(1) per tick' if one else 'one run'}"
            after = [statistics.median(t[2] / t[0] for t in turns) for turns in took]
            control = [statistics.median(t[1] / t[0] for t in turns) for turns in took]
            seconds = statistics.median(t[2] for turns in took for t in turns)
            results[key] = {
                **interval(after),
                "control": interval(control),
                "sets": sets,
                "turns": TURNS,
                "ms per tick": round(1000 * seconds / turn_ticks, 3),
            }
            print(key, json.dumps(results[key]), flush=True)
    return results


def systems(before: Path, sets: int, worlds: list[str]) -> dict[str, Any]:
    """Return, for each of these worlds, each system's shortest time per tick [µs], and the ratio of complete
    ticks."""
    results: dict[str, Any] = {}
    for name in worlds:
        world, changes, ticks = WORLDS[name]
        least: list[dict[str, list[float]]] = [{}, {}]  # before and after: by system and tick
        for _ in range(sets):
            with living([before, ROOT], [world, changes, ticks], SYSTEMS) as turn:
                turn(0)  # compiles
                for number in range(TURNS):
                    for known, took in zip(least, turn(number), strict=True):
                        for system, times in took.items():
                            known[system] = list(map(min, known.get(system, times), times))
        was, now = (
            {system: 1e6 * statistics.fmean(times) for system, times in known.items()} for known in least
        )
        both = {
            system: [round(was.get(system, 0.0), 1), round(now.get(system, 0.0), 1)]
            for system in sorted(was.keys() | now.keys())
        }
        changed = {
            system: pair
            for system, pair in both.items()
            if abs(pair[1] - pair[0]) > 0.005 * was["whole tick"] and system != "whole tick"
        }
        results[name] = {
            "ratio": round(now["whole tick"] / was["whole tick"], 4),
            "us per tick": both["whole tick"],
            "changed by more than 0.5%": changed,
            "systems": both,
        }
        print(
            name,
            json.dumps({key: some for key, some in results[name].items() if key != "systems"}),
            flush=True,
        )
    return results


@contextmanager
def living(places: list[Path], asked: Any, code: str = TIME) -> Iterator[Callable[[int], list[Any]]]:
    """Yield a function that runs each process's next world for a turn, in an order that depends on the turn
    number, and returns the seconds that the processes report."""
    worlds = [
        subprocess.Popen(
            [sys.executable, "-c", code, json.dumps(asked)],
            cwd=place,
            text=True,
            env=environment(place),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        for place in places
    ]

    def turn(number: int) -> list[Any]:
        took: list[Any] = [0.0] * len(worlds)
        for i in range(len(worlds)):
            this = (i + number) % len(worlds)
            pipes = worlds[this]
            assert pipes.stdin is not None
            assert pipes.stdout is not None
            pipes.stdin.write("\n")
            pipes.stdin.flush()
            took[this] = json.loads(pipes.stdout.readline())
        return took

    try:
        yield turn
    finally:
        for process in worlds:
            process.kill()
            process.communicate()


def starts(before: Path, pairs: int, firsts: int) -> dict[str, Any]:
    """Return the comparison for complete processes: runs of 100 ticks with compiled kernels, without and with
    their report; first starts with an empty cache; and the loaded modules and compiled kernels."""
    out: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        caches = {place: Path(folder) / name for place, name in ((before, "before"), (ROOT, "after"))}
        for place, cache in caches.items():
            word = "before" if place == before else "after"
            compileall.compile_dir(place / "ecs_eco", quiet=2)  # as pip does during installation
            begun = start(place, cache, True)[0]  # compiles
            out.setdefault("100 ticks, first start, with its report, once [s]", {})[word] = round(begun, 2)
            out.setdefault("loads", {})[word] = start(place, cache, False)[1]
            print(word, f"{begun:.2f} s at first", flush=True)
        for name, report in (("without its report", False), ("with its report", True)):

            def second(place: Path, report: bool = report) -> float:
                return start(place, caches[place], report)[0]

            ratio, took = paired(before, pairs, second)
            out[f"100 ticks, second start, {name}"] = ratio | {"s": took}
        if firsts:
            ratio, took = paired(before, firsts, first)
            out["100 ticks, first start"] = ratio | {"s": took}
    return out


def start(place: Path, cache: Path, report: bool) -> tuple[float, dict[str, Any]]:
    """Return the seconds that a process takes for a frozen run of 100 ticks with the kernels in `cache`, and
    the modules that it loaded."""
    with tempfile.TemporaryDirectory() as folder:
        words = ["run", "predator-prey", "--ticks", "100", "--quiet", *([] if report else ["--no-report"])]
        command = [sys.executable, "-c", START, *words, "--out", f"{folder}/run"]
        surroundings = environment(place) | {"ECS_ECO_CACHE": str(cache)}
        begin = time.perf_counter()
        done = subprocess.run(
            command, cwd=place, env=surroundings, check=True, capture_output=True, text=True
        )
        took = time.perf_counter() - begin
    return took, json.loads(done.stdout.splitlines()[-1]) | {"kernels": len(list(cache.rglob("*.nbc")))}


def first(place: Path) -> float:
    """Return the seconds that a run without a report takes with an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        return start(place, Path(folder) / "cache", False)[0]


def paired(before: Path, pairs: int, measure: Callable[[Path], float]) -> tuple[dict[str, Any], Any]:
    """Return the median ratio of this commit's seconds to the other's, with its interval, and both medians of
    seconds."""
    ratios, seconds = [], []
    for number in range(pairs):
        order = (before, ROOT) if number % 2 else (ROOT, before)
        took = {place: measure(place) for place in order}
        ratios.append(took[ROOT] / took[before])
        seconds.append((took[before], took[ROOT]))
        print(f"{took[before]:.2f} s before, {took[ROOT]:.2f} s after", flush=True)
    middle = [round(statistics.median(column), 3) for column in zip(*seconds, strict=True)]
    return interval(ratios) | {"pairs": pairs}, dict(zip(("before", "after"), middle, strict=True))


def interval(ratios: list[float]) -> dict[str, float]:
    """Return the median ratio and its bootstrapped 95% interval."""
    draws = random.Random(1)
    medians = sorted(statistics.median(draws.choices(ratios, k=len(ratios))) for _ in range(2000))
    return {
        "ratio": round(statistics.median(ratios), 4),
        "from": round(medians[50], 4),
        "to": round(medians[-51], 4),
    }


def main() -> int:
    """Compare the commits and store the results; return 1 if they differ."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("what", choices=["digests", "times", "systems", "starts"])
    parser.add_argument("--before", required=True, metavar="COMMIT")
    parser.add_argument("--pairs", type=int, default=12, help="pairs of starts")
    parser.add_argument("--firsts", type=int, default=3, help="pairs of first starts")
    parser.add_argument("--sets", type=int, default=8, help="sets of timed processes")
    parser.add_argument("--worlds", nargs="+", choices=list(WORLDS), default=list(WORLDS), metavar="NAME")
    given = parser.parse_args()
    git = {
        name: subprocess.run(
            ["git", "rev-parse", "--short", name], cwd=ROOT, capture_output=True, text=True, check=True
        ).stdout.strip()
        for name in (given.before, "HEAD")
    }
    with tempfile.TemporaryDirectory() as folder:
        files = subprocess.run(
            ["git", "archive", given.before], cwd=ROOT, capture_output=True, check=True
        ).stdout
        subprocess.run(["tar", "x", "-C", folder], input=files, check=True)
        place = Path(folder)
        result = (
            digests(place)
            if given.what == "digests"
            else times(place, given.sets, given.worlds)
            if given.what == "times"
            else systems(place, given.sets, given.worlds)
            if given.what == "systems"
            else starts(place, given.pairs, given.firsts)
        )
    record = {"before": git[given.before], "after": git["HEAD"], "load": os.getloadavg()[0], **result}
    (RESULTS / f"before_after_{given.what}.json").write_text(
        json.dumps(record, indent=1) + "\n", encoding="utf-8"
    )
    return int(given.what == "digests" and result["equal"] < len(result["cases"]))


if __name__ == "__main__":
    sys.exit(main())
