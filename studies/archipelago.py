"""Does an archipelago end in the same state regardless of which workers compute it and how often they are
killed?

The archipelago is a grid of eight islands where goats act by reflex and eat three kinds of grass; one island
overrides one value. The goats have individual policies, learn by PPO, and migrate. Each case runs the same
archipelago in a different way and stores its digest, a hash of all islands' digests:

  plain           one worker, in this process
  workers         two workers
  worker killed   two workers; one of them is killed with SIGKILL `kills` times, at random moments
  all killed      the whole run, in a separate process group, is killed with SIGKILL `kills` times
  Ray             two Ray workers, if Ray is installed

Before the first run, we expected all cases to give the same digest.
"""

from __future__ import annotations

import importlib.util
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

from studies.common.study import Study, verdict

WAYS = (
    "plain",
    "workers",
    "worker killed",
    "all killed",
    *(("Ray",) if importlib.util.find_spec("ray") else ()),
)
ISLANDS: dict[str, Any] = {f"island_{i}": {} for i in range(1, 8)} | {"steep": {"species.goat.count": 8}}
CODE = (
    "import sys; from ecs_eco.lab import Archipelago; Archipelago(sys.argv[1]).run(workers=2, report=False)"
)


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one case's archipelago; return its digest, duration [s], number of barriers and number of kills."""
    from ecs_eco.config import load
    from ecs_eco.lab import Archipelago

    world = load(config["world"], config["changes"] | {"archipelago": config["archipelago"]})
    with tempfile.TemporaryDirectory(prefix="ecs-eco-islands-") as place:
        made = Archipelago.from_config(
            world,
            seed=case["seed"],
            ticks=config["ticks"],
            out=Path(place) / "run",
            policies="untrained",
            learn=True,
        )
        start = time.perf_counter()
        kills = WAY[case["way"]](made, config, case)
        made = Archipelago(made.folder)
        moved = sum(
            n
            for state in made.manifest["islands"].values()
            for to in state["sent"].values()
            for n in to.values()
        )
        return {
            "digest": made.digest,
            "tick": made.tick,
            "kills": kills,
            "run seconds": round(time.perf_counter() - start, 1),
            "emigrants at the end": moved,
            "islands": {name: state["n"] for name, state in made.manifest["islands"].items()},
        }


def plain(made: Any, config: dict[str, Any], case: dict[str, Any]) -> int:
    """Run all islands in this process."""
    made.run(report=False)
    return 0


def workers(made: Any, config: dict[str, Any], case: dict[str, Any]) -> int:
    """Run the islands with two workers."""
    made.run(workers=2, report=False)
    return 0


def on_ray(made: Any, config: dict[str, Any], case: dict[str, Any]) -> int:
    """Run the islands with two Ray workers."""
    made.run(workers=2, on="ray", report=False)
    return 0


def worker_killed(made: Any, config: dict[str, Any], case: dict[str, Any]) -> int:
    """Run the islands with two workers, killing one of them at random moments."""
    from ecs_eco.lab.pool import Pool

    pool, done, over = Pool(2), [0], threading.Event()
    chance = random.Random(case["seed"])

    def kill() -> None:
        while done[0] < config["kills"] and not over.wait(chance.uniform(0.2, 1.0) * config["pause"]):
            processes = list(getattr(pool._processes, "_processes", None) or {})
            if processes:
                os.kill(chance.choice(processes), signal.SIGKILL)
                done[0] += 1

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        with pool:
            made.run(on=pool, report=False)
    finally:
        over.set()
        killer.join()
    return done[0]


def all_killed(made: Any, config: dict[str, Any], case: dict[str, Any]) -> int:
    """Run the archipelago in a separate process group, killing the whole group as many times as required."""
    chance, kills = random.Random(case["seed"]), 0
    while True:
        process = subprocess.Popen([sys.executable, "-c", CODE, str(made.folder)], start_new_session=True)
        try:
            pause = (3 + chance.uniform(0.2, 1.0) * config["pause"]) if kills < config["kills"] else None
            if process.wait(pause) == 0:
                return kills
            raise RuntimeError(f"the run ended with exit code {process.returncode}")
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            kills += 1


WAY = dict(
    zip(
        ("plain", "workers", "worker killed", "all killed", "Ray"),
        (plain, workers, worker_killed, all_killed, on_ray),
        strict=True,
    )
)


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Compare the digests of all cases and count the kills."""
    digests = {e["case"]["way"]: e["result"]["digest"] for e in cases}
    kills = sum(e["result"]["kills"] for e in cases)
    moved = min(e["result"]["emigrants at the end"] for e in cases)
    rows = [
        [e["case"]["way"], e["result"]["kills"], e["result"]["run seconds"], e["result"]["digest"][:16]]
        for e in cases
    ]
    return {
        "verdicts": [
            verdict(
                "distinct digests of the archipelago",
                len(set(digests.values())),
                "1 for all methods",
                len(set(digests.values())) == 1,
            ),
            verdict("workers and runs killed", kills, "20", kills >= 20),
            verdict("emigrants at the last barrier", moved, "1 or more", moved > 0),
        ],
        "table": {"head": ["method", "kills", "seconds", "digest"], "rows": rows},
    }


STUDY = Study(
    name="archipelago",
    claim="An archipelago ends with the same bytes for any number of workers, on any engine and after any kill.",
    config={
        "world": "reflexes",
        "ticks": 5000,
        "kills": 10,
        "pause": 3.0,
        "changes": {"species.goat.policy.kind": "individual", "species.goat.policy.learn": True},
        "archipelago": {"islands": ISLANDS, "every": 250, "graph": "grid", "emigration": {"goat": 0.05}},
    },
    cases=[{"way": way, "seed": 1} for way in WAYS],
    run=run,
    summarise=summarise,
    short_cases=[{"way": way, "seed": 1} for way in ("plain", "worker killed")],
    short_config={
        "ticks": 30,
        "kills": 1,
        "pause": 4.0,
        "archipelago": {
            "islands": {"one": {}, "other": {"species.goat.count": 40}},
            "every": 10,
            "graph": "full",
            "emigration": {"goat": 0.2},
        },
    },
)

if __name__ == "__main__":
    STUDY.main()
