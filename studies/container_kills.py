"""Do sweeps, searches, archipelagos and comparisons that are killed repeatedly end like uninterrupted ones?

  local  a forked process starts or resumes the container and is killed with SIGKILL at random moments of the
         time that an uninterrupted one takes
  Ray    the container runs on a Ray cluster of this machine, and a worker is killed at random moments: within six
         seconds after it became busy if it is new, since its first call takes about three, so that some calls end
         and some are repeated; otherwise within the time that an uninterrupted container takes

Finished work must still be there, unchanged, after each kill. A container that is finished before enough kills
have been counted is compared, and the next one begins. Each case counts 50 kills, so a stopped study loses at
most these.
"""

from __future__ import annotations

import importlib.util
import os
import signal
import tempfile
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.study import Study, verdict
from studies.kills import kill_once

COUNT = "species.moss.count"
WORLD: dict[str, Any] = {
    "format": 1,
    "name": "moss",
    "space": {"size": [12.0, 12.0]},
    "species": {
        "moss": {
            "count": 20,
            "body": {"radius": 0.1, "mass": 0.1},
            "metabolism": {"energy": 0.8, "energy_max": 1.0, "basal": 0.0001},
            "reproduction": {"kind": "asexual", "rate": 0.02, "energy_min": 0.5, "energy_given": 0.2},
            "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
        }
    },
}
ISLANDS = {
    "migration_interval": 20,
    "migration_probability": {"moss": 0.1},
    "islands": {"north": {}, "south": {}},
}
SEARCH = {
    "objective": "population",
    "wanted": {"moss": 60},
    "world_seeds": 2,
    "finalists": 1,
    "confirm": {"world_seeds": 2},
}
KINDS = ("sweep", "search", "archipelago", "comparison")
ENGINES = ("local", *(("ray",) if importlib.util.find_spec("ray") else ()))
TIMES = ("seconds", "cpu", "at", "seal")  # entries of a search's journal that differ between equal searches


def live(kind: str, folder: Path, config: dict[str, Any], engine: str) -> None:
    """Start or resume a container, one call at a time."""
    from ecs_eco.lab import Archipelago, compare, run_sweep, search

    ticks, every = config["ticks"], max(1, config["ticks"] // 8)
    own: dict[str, Any] = {"executor": engine, "workers": 1}
    if kind == "sweep":
        plan = {"world": WORLD, "ticks": ticks, "world_seeds": 3, "checkpoint_every": every}
        run_sweep(plan | {"grid": {COUNT: [10, 20]}}, folder, **own)
    elif kind == "search":
        species = {"moss": WORLD["species"]["moss"] | {"count": {"value": 20, "search": [5, 40]}}}
        world = WORLD | {"ticks": ticks, "species": species, "search": SEARCH}
        search(world, folder, trials=4, optimiser="random", report=False, **own)
    elif kind == "archipelago":
        if not (folder / "archipelago.json").is_file():
            world = WORLD | {"archipelago": ISLANDS}
            Archipelago.from_config(world, seed=1, ticks=ticks, out=folder)
        Archipelago(folder).run(on=engine, workers=1, report=False)
    else:
        compare(WORLD, [f"{COUNT}=5"], out=folder, seeds=3, ticks=ticks, **own)


def finished(kind: str, folder: Path, ticks: int) -> dict[str, Any]:
    """Return the finished work, without times: digests of runs by folder, of a whole archipelago, or evaluations
    of a search."""
    from ecs_eco.lab import Archipelago
    from ecs_eco.lab.searching.journal import NAME, read
    from ecs_eco.record.seal import read_manifest

    if kind == "search":
        lines = read(folder / NAME) if (folder / NAME).is_file() else []
        return {str(i): _without_times(line) for i, line in enumerate(lines)}
    if kind == "archipelago":  # islands change until the last barrier
        made = Archipelago(folder) if (folder / "archipelago.json").is_file() else None
        return {} if made is None or made.tick < ticks else {"digest": made.digest}
    runs = (file.parent for file in folder.rglob("manifest.json"))
    manifests = {str(run.relative_to(folder)): read_manifest(run) for run in runs}
    return {name: m["digest"] for name, m in manifests.items() if m["done"] >= m["ticks"] and m["finished"]}


def _without_times(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_times(own) for key, own in value.items() if key not in TIMES}
    return [_without_times(own) for own in value] if isinstance(value, list) else value


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Kill containers of one kind the required number of times, and compare them with an uninterrupted one."""
    kind, engine, config = case["kind"], case["engine"], dict(config)
    rng, warm = np.random.default_rng(case["seed"]), set[int]()
    result = {"kills": 0, "containers": 0, "different": 0, "lost": 0}
    with tempfile.TemporaryDirectory() as place:
        live(kind, Path(place) / "peace", config, "local")
        whole = finished(kind, Path(place) / "peace", config["ticks"])
        began = time.perf_counter()
        live(kind, Path(place) / "timed", config, "local")
        config |= {"longest": min(config["longest"], time.perf_counter() - began)}
        while result["kills"] < config["kills"] and result["containers"] < 2 * config["kills"]:
            folder = Path(place) / f"killed-{result['containers']}"
            left = config["kills"] - result["kills"]
            if engine == "local":
                kills, lost = locally(kind, folder, config, rng, left)
            else:
                kills, lost = on_ray(kind, folder, config, rng, left, warm)
            result["kills"] += kills
            result["containers"] += 1
            result["lost"] += lost
            result["different"] += finished(kind, folder, config["ticks"]) != whole
    return result


def locally(
    kind: str, folder: Path, config: dict[str, Any], rng: np.random.Generator, most: int
) -> tuple[int, int]:
    """Kill the process of a container up to `most` times, then let it finish; return the number of kills, and
    of pieces of finished work that were lost or changed."""
    kills = lost = 0
    before: dict[str, Any] = {}
    while kills < most:
        ended = kill_once(
            lambda: live(kind, folder, config, "local"), float(rng.uniform(0.0, config["longest"]))
        )
        now = finished(kind, folder, config["ticks"]) if folder.exists() else {}
        lost += sum(now.get(name) != work for name, work in before.items())
        before = now
        if ended:
            return kills, lost
        kills += 1
    live(kind, folder, config, "local")
    return kills, lost


def on_ray(
    kind: str, folder: Path, config: dict[str, Any], rng: np.random.Generator, most: int, warm: set[int]
) -> tuple[int, int]:
    """Kill the Ray worker of the running call up to `most` times; return as `locally` does. `warm` collects the
    workers that have finished a call."""
    import ray

    if not ray.is_initialized():
        ray.init(num_cpus=1, include_dashboard=False, log_to_driver=False)
    over, kills, lost = threading.Event(), [0], [0]

    def kill() -> None:
        before: dict[str, Any] = {}
        while kills[0] < most and not over.wait(0.01):
            if not (busy := busy_workers(ray)):
                continue
            longest = config["longest"] if busy[0] in warm else 0.5 * config["pause"]
            over.wait(float(rng.uniform(0.0, longest)))
            with suppress(ProcessLookupError):
                if busy[0] in busy_workers(ray):
                    os.kill(busy[0], signal.SIGKILL)
                    kills[0] += 1
                else:
                    warm.add(busy[0])
            now = finished(kind, folder, config["ticks"]) if folder.exists() else {}
            lost[0] += sum(now.get(name) != work for name, work in before.items())
            before = now

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        live(kind, folder, config, "ray")
    finally:
        over.set()
        killer.join()
    return kills[0], lost[0]


def busy_workers(ray: Any) -> list[int]:
    """Return the processes that run a call, among the children of this process's own raylet."""
    (raylet,) = ray._private.worker._global_node.all_processes["raylet"]
    found = []
    for task in Path(f"/proc/{raylet.process.pid}/task").iterdir():
        for pid in (task / "children").read_text().split():
            with suppress(FileNotFoundError):  # it has just ended
                if Path(f"/proc/{pid}/cmdline").read_bytes().startswith(b"ray::_call"):
                    found.append(int(pid))
    return found


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Count kills, and containers that ended differently, by kind and engine."""
    rows: dict[tuple[str, str], list[int]] = {}
    for case in cases:
        numbers = [case["result"][word] for word in ("kills", "containers", "different", "lost")]
        own = rows.setdefault((case["case"]["kind"], case["case"]["engine"]), [0] * 4)
        own[:] = np.add(own, numbers).tolist()
    fewest = min(numbers[0] for numbers in rows.values())
    different, lost = (sum(numbers[i] for numbers in rows.values()) for i in (2, 3))
    return {
        "verdicts": [
            verdict("fewest kills (SIGKILL) of a kind on an engine", fewest, "200 or more", fewest >= 200),
            verdict("containers that differ from an uninterrupted one", different, "0", different == 0),
            verdict("finished runs or evaluations lost or changed by a kill", lost, "0", lost == 0),
        ],
        "table": {
            "head": ["container", "engine", "kills", "containers", "different", "lost"],
            "rows": [[*key, *numbers] for key, numbers in rows.items()],
        },
    }


STUDY = Study(
    name="container_kills",
    claim="Sweeps, searches, archipelagos and comparisons that are killed at any moment can be resumed, and end "
    "like uninterrupted ones.",
    config={"ticks": 200, "kills": 50, "longest": 2.0, "pause": 12.0},
    cases=[
        {"kind": kind, "engine": engine, "seed": seed}
        for engine in ENGINES
        for kind in KINDS
        for seed in range(1, 5)
    ],
    run=run,
    summarise=summarise,
    short_config={"ticks": 40, "kills": 3, "longest": 1.0},
    short_cases=[{"kind": kind, "engine": "local", "seed": 1} for kind in KINDS],
)

if __name__ == "__main__":
    STUDY.main()
