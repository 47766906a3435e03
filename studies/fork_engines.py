"""Do the forks of `ecs-eco explain` have the same results on every engine, even if the command is killed?

The allele of the reflex against red grass is taken out in forks of one run of the world `reflexes`, by one process;
by two processes; on a Ray cluster of this machine; and as a job array of SLURM. The call is killed with SIGKILL
after a third of the forks, then it is made again. Ray is skipped where it is not installed. Where no SLURM answers,
the tests' stand-in for its commands is used, and the table names it (see tools/slurm_on_one_node.sh).
"""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from studies.common.study import Study, verdict
from studies.sweep import stand_in

CALL = "import json, sys; from studies.fork_engines import take; take(**json.loads(sys.argv[1]))"
ENGINES = ("one process", "local", "ray", "slurm")


def take(run: str, engine: str, forks: int, ticks: int, tick: int) -> None:
    """Take the allele out in these forks."""
    from ecs_eco.explain import Edit, take_out

    one, on = engine == "one process", "local" if engine == "one process" else engine
    red = Edit("goat", "letter", gene="red", locus=0, value="T")
    take_out(run, red, tick=tick, forks=forks, ticks=ticks, engine=on, workers=1 if one else 2)


@contextmanager
def cluster(engine: str) -> Iterator[str]:
    """Provide what an engine needs; yield its name and version."""
    if engine == "ray":
        import ray
        from ray.cluster_utils import Cluster

        own = Cluster(initialize_head=True, head_node_args={"num_cpus": 2})
        os.environ["RAY_ADDRESS"] = own.address
        try:
            yield f"Ray {ray.__version__}"
        finally:
            own.shutdown()
            del os.environ["RAY_ADDRESS"]
    elif engine == "slurm" and not (
        shutil.which("sinfo") and subprocess.run(["sinfo"], capture_output=True).returncode == 0
    ):
        with tempfile.TemporaryDirectory() as place, stand_in(Path(place) / "slurm"):
            yield "stand-in for SLURM"
    elif engine == "slurm":
        yield subprocess.run(["sinfo", "--version"], capture_output=True, text=True).stdout.strip()
    else:
        yield engine


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run the forks on one engine; return their results, and what was done again after the kill."""
    from ecs_eco.record import run_to_folder

    engine = case["engine"]
    if engine == "ray" and importlib.util.find_spec("ray") is None:
        return {"note": "ray is not installed"}
    with cluster(engine) as name, tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "run"
        run_to_folder("reflexes", seed=config["seed"], ticks=config["ticks"], out=folder, report=False)
        options = {key: config[key] for key in ("forks", "ticks", "tick")}
        command = [sys.executable, "-c", CALL, json.dumps({"run": str(folder), "engine": engine, **options})]
        begin = time.perf_counter()
        call = subprocess.Popen(command, start_new_session=True)
        while len(before := ended(folder)) < config["forks"] / 3:
            if call.poll() is not None:
                raise RuntimeError(f"{engine}: ended with {call.returncode} after {len(before)} forks")
            time.sleep(0.02)
        os.killpg(call.pid, signal.SIGKILL)
        call.wait()
        subprocess.run(command, check=True)
        after = ended(folder)
        return {
            "engine": name,
            "seconds": round(time.perf_counter() - begin, 1),
            "ended before the kill": len(before),
            "run again": sum(after[path] != written for path, written in before.items()),
            "forks": [json.loads(path.read_text(encoding="utf-8")) for path in sorted(after)],
        }


def ended(folder: Path) -> dict[Path, int]:
    """Return the files of the forks that have ended, and when each was written [ns]."""
    return {path: path.stat().st_mtime_ns for path in folder.glob("explain/*/fork-*.json")}


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Compare the results of the forks with those of one process."""
    results = {e["case"]["engine"]: e["result"] for e in cases if "note" not in e["result"]}
    wanted = results["one process"]["forks"]
    verdicts, rows = [], []
    for engine, one in results.items():
        same = sum(a == b for a, b in zip(one["forks"], wanted, strict=False))
        everything = same == len(wanted) == len(one["forks"])
        if engine != "one process":
            says = f"{engine}: forks with the same results as in one process, of {len(wanted)}"
            verdicts.append(verdict(says, same, f"{len(wanted)}", everything))
        says = f"{engine}: forks that had ended before the kill and were run again"
        verdicts.append(verdict(says, one["run again"], "0", one["run again"] == 0))
        lasted = sum(fork["lasted"] for fork in one["forks"]) / len(one["forks"])
        rows.append([one["engine"], len(one["forks"]), lasted, one["ended before the kill"], one["seconds"]])
    head = ["engine", "forks", "mean length [ticks]", "ended before the kill", "wall time [s]"]
    return {"verdicts": verdicts, "table": {"head": head, "rows": rows}}


STUDY = Study(
    name="fork_engines",
    claim="The forks of `ecs-eco explain` have the same results on local processes, Ray and SLURM, after a kill.",
    config={"seed": 41, "ticks": 2000, "tick": 500, "forks": 24},
    cases=[{"engine": engine} for engine in ENGINES],
    run=run,
    summarise=summarise,
    short_config={"ticks": 60, "tick": 30, "forks": 3},
    short_cases=[{"engine": engine} for engine in ("one process", "local")],
)

if __name__ == "__main__":
    STUDY.main()
