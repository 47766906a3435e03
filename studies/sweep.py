"""Does a sweep produce the same digests on every engine, even if processes are killed?

The same plan runs on local processes, one of which is killed; on a Ray cluster of two nodes on this machine,
where a worker is killed and then a node; and as a job array on a stand-in for SLURM, where running jobs are
preempted and later asked to stop. Engines that are not installed are skipped with a note.
"""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from studies.common.study import Study, verdict

SMALL = {
    "space.size": [60.0, 60.0],
    "species.grass.count": 270,
    "species.deer.count": 44,
    "species.wolf.count": 5,
}
# detect a lost node within 5 s
SOON = {"health_check_initial_delay_ms": 1000, "health_check_period_ms": 1000}
ENGINES = ("bare", "local", "ray", "slurm")


def plan_of(config: dict[str, Any]) -> dict[str, Any]:
    """Return the plan: a grid of two parameters, with seeds."""
    return {
        "world": "predator-prey",
        "ticks": config["ticks"],
        "world_seeds": config["seeds"],
        "policies": "random",
        "checkpoint_every": max(1, config["ticks"] // 8),
        "set": SMALL,
        "grid": {
            "species.deer.reproduction.rate": config["rates"],
            "species.deer.metabolism.basal": config["basal"],
        },
    }


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run the sweep on one engine; return its digests in job order, and the events."""
    engine = case["engine"]
    if engine == "ray" and importlib.util.find_spec("ray") is None:
        return {"note": "ray is not installed", "digests": []}
    with tempfile.TemporaryDirectory() as place:
        begin = time.perf_counter()
        note = {"bare": bare, "local": local, "ray": on_ray, "slurm": on_slurm}[engine](
            plan_of(config), Path(place) / "sweep", config
        )
        seconds = time.perf_counter() - begin
        digests = note.pop("digests") if engine == "bare" else collected(Path(place) / "sweep")
        return {**note, "digests": digests, "seconds": round(seconds, 2)}


def bare(plan: dict[str, Any], folder: Path, config: dict[str, Any]) -> dict[str, Any]:
    """Run the same worlds one after another, without a sweep."""
    from ecs_eco.config import load
    from ecs_eco.lab.design import design_of
    from ecs_eco.lab.plan import read_plan
    from ecs_eco.record import run_to_folder

    design, digests = design_of(read_plan(plan)), []
    for job in design.jobs:
        done = run_to_folder(
            load(design.base, job.values),
            seed=job.world_seed,
            ticks=config["ticks"],
            out=folder / str(job.number),
            policies="random",
            report=False,
        )
        digests.append(done["digest"])
    return {"digests": digests}


def collected(folder: Path) -> list[str]:
    """Return the digests from a sweep's table."""
    from ecs_eco.lab.folder import read_sweep
    from ecs_eco.lab.table import rows_of

    return [row["digest"] for row in rows_of(read_sweep(folder))]


def local(plan: dict[str, Any], folder: Path, config: dict[str, Any]) -> dict[str, Any]:
    """Run on two local processes; kill one of them after a third of the jobs."""
    from ecs_eco.lab import run_sweep
    from ecs_eco.lab.pool import Pool

    killed: list[int] = []

    def kill() -> None:
        pid = wait_for(folder, config, lambda: pid_of_running(folder, but=os.getpid()))
        killed.append(pid)
        os.kill(pid, signal.SIGKILL)

    thread = threading.Thread(target=kill, daemon=True)
    thread.start()
    with Pool(2) as pool:
        outcome = run_sweep(plan, folder, executor=pool)
    return {"killed workers": len(killed), "repeated calls": outcome.retried, "failed": outcome.failed}


def on_ray(plan: dict[str, Any], folder: Path, config: dict[str, Any]) -> dict[str, Any]:
    """Run on a Ray cluster; kill a worker, then a node."""
    from ray.cluster_utils import Cluster

    from ecs_eco.lab import run_sweep

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "_system_config": SOON})
    second = cluster.add_node(num_cpus=1)
    os.environ["RAY_ADDRESS"] = cluster.address
    lost: list[str] = []

    def kill() -> None:
        os.kill(wait_for(folder, config, lambda: pid_of_running(folder)), signal.SIGKILL)
        lost.append("a worker")
        time.sleep(2)
        wait_for(folder, config, lambda: pid_of_running(folder))
        cluster.remove_node(second, allow_graceful=False)
        lost.append("a node")

    thread = threading.Thread(target=kill, daemon=True)
    thread.start()
    try:
        outcome = run_sweep(plan, folder, executor="ray")
    finally:
        thread.join(timeout=60)
        cluster.shutdown()
        del os.environ["RAY_ADDRESS"]
    return {"killed": lost, "failed": outcome.failed}


def on_slurm(plan: dict[str, Any], folder: Path, config: dict[str, Any]) -> dict[str, Any]:
    """Run as a job array on the stand-in; preempt running jobs twice, and ask them to stop once."""
    from ecs_eco.lab.design import design_of
    from ecs_eco.lab.folder import begin
    from ecs_eco.lab.plan import read_plan
    from ecs_eco.lab.slurm import Options, jobs_of, submit_jobs

    sweep = begin(folder, design_of(read_plan(plan)))
    with stand_in(folder.parent / "slurm") as state:
        numbers = sweep.evenly([job.number for job in sweep.jobs])
        (array,) = submit_jobs(jobs_of(sweep), numbers, Options(limit=2))

        def tasks(*states: str) -> list[str]:
            now = json.loads((state / "state.json").read_text())["arrays"][array]["tasks"]
            return [index for index, task in now.items() if task["state"] in states]

        def times(word: str) -> int:
            now = json.loads((state / "state.json").read_text())["arrays"][array]["tasks"]
            return sum(task["log"].count(word) for task in now.values())

        for share, command, word in (
            (1 / 4, "preempt", "preempt"),
            (1 / 2, "preempt", "preempt"),
            (3 / 4, "notice", "signalled"),
        ):
            before = times(word)
            while times(word) == before:  # jobs that have ended by then need no signal
                for index in wait_for(folder, config | {"at": share}, lambda: tasks("RUNNING")):
                    subprocess.run([command, array, index], check=True)
                time.sleep(0.2)
        wait_for(folder, config | {"at": 1.0}, lambda: not tasks("RUNNING", "PENDING"))
        content = json.loads((state / "state.json").read_text())["arrays"][array]["tasks"]
    words = [word for task in content.values() for word in task["log"]]
    return {
        "preempted": words.count("preempt"),
        "asked to stop": words.count("signalled"),
        "restarts": sum(task["restarts"] for task in content.values()),
    }


@contextmanager
def stand_in(place: Path) -> Iterator[Path]:
    """Put the commands of a stand-in for SLURM on the path; return its state folder."""
    place.mkdir()
    root = Path(__file__).parents[1]
    for name in ("sbatch", "squeue", "scontrol", "preempt", "notice"):
        program = root / "tests" / "lab" / "slurm_stand_in.py"
        (place / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" "{program}" {name} "$@"\n')
        (place / name).chmod(0o755)
    paths = os.pathsep.join([str(root), *filter(None, [os.environ.get("PYTHONPATH")])])
    own = {
        "PATH": f"{place}{os.pathsep}{os.environ['PATH']}",
        "SLURM_STAND_IN": str(place),
        "PYTHONPATH": paths,
    }
    before = {name: os.environ.get(name) for name in own}
    os.environ.update(own)
    try:
        yield place
    finally:
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value


# --- processes and their jobs ------------------------------------------------------------------------------


def wait_for(folder: Path, config: dict[str, Any], what: Callable[[], Any]) -> Any:
    """Wait until a share of the jobs is done and the function returns a result; return that result."""
    until = time.monotonic() + config["patience"]
    enough = config.get("at", 1 / 3) * config["seeds"] * len(config["rates"]) * len(config["basal"])
    while time.monotonic() < until:
        if len(list(folder.glob("jobs/*/done.json"))) >= int(enough) and (found := what()):
            return found
        time.sleep(0.02)
    raise TimeoutError(f"{folder}: nothing to kill within {config['patience']} s")


def pid_of_running(folder: Path, but: int = 0) -> int:
    """Return the id of a process that runs a job, or 0."""
    from ecs_eco.record.claim import owner_of

    owners = (owner_of(lock.parent) for lock in folder.glob("jobs/*/.lock"))
    return next((int(owner["pid"]) for owner in owners if owner and owner["pid"] != but), 0)


def summarise(cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Compare the digests with those of the bare runs."""
    results = {case["case"]["engine"]: case["result"] for case in cases}
    wanted = results["bare"]["digests"]
    lines = []
    for engine, result in results.items():
        if engine == "bare" or "note" in result:
            continue
        same = sum(a == b for a, b in zip(result["digests"], wanted, strict=False))
        lines.append(
            verdict(
                f"{engine}: runs with the same digest as the bare run, of {len(wanted)}",
                same,
                f"{len(wanted)}",
                same == len(wanted) == len(result["digests"]),
            )
        )
    if "local" in results:
        killed = results["local"]["killed workers"]
        lines.append(verdict("local: workers killed", killed, "1 or more", killed >= 1))
    if "note" not in results.get("ray", {"note": ""}):
        lines.append(
            verdict(
                "ray: killed",
                ", ".join(results["ray"]["killed"]),
                "a worker, a node",
                results["ray"]["killed"] == ["a worker", "a node"],
            )
        )
    if "slurm" in results:
        counts = [results["slurm"][word] for word in ("preempted", "asked to stop", "restarts")]
        lines.append(
            verdict(
                "slurm: jobs preempted, asked to stop, requeued",
                counts,
                "1 or more of each",
                min(counts) >= 1,
            )
        )
    return lines


STUDY = Study(
    name="sweep",
    claim="A sweep ends with the same digests on local processes, on Ray and on SLURM, after any kill.",
    config={
        "ticks": 1000,
        "seeds": 5,
        "rates": [0.006, 0.01, 0.014, 0.018, 0.022],
        "basal": [0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.009, 0.01],
        "patience": 3600,
    },
    cases=[{"engine": engine} for engine in ENGINES],
    run=run,
    summarise=summarise,
    short_config={"ticks": 40, "seeds": 2, "rates": [0.006, 0.02], "basal": [0.004], "patience": 600},
    short_cases=[{"engine": engine} for engine in ("bare", "local")],
)

if __name__ == "__main__":
    STUDY.main()
