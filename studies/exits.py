"""A process that records a run and reads it back ends with exit code 0."""

import subprocess
import sys
import tempfile
from typing import Any

from studies.common.study import Study, verdict

WORK = """
import sys
from pathlib import Path
from ecs_eco.analysis.runs import load_series
from ecs_eco.record.parquet import read_part
from ecs_eco.runs.run import run_to_folder
from studies.common.runs import small

out = Path(sys.argv[1])
run_to_folder(small("predator-prey", 0.1), seed=int(sys.argv[2]), ticks=20, out=out, policies="random",
              snapshot_every=2, report=False)
load_series(out)
for kind in ("births", "deaths", "snapshots"):
    for part in sorted((out / kind).glob("*.parquet")):
        read_part(part)
"""


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Start the given number of processes one after another; return the number that ended with each code, and
    the error output of the processes that failed."""
    codes: dict[str, int] = {}
    complaints = []
    for i in range(config["processes"]):
        with tempfile.TemporaryDirectory() as place:
            done = subprocess.run(
                [sys.executable, "-c", WORK, f"{place}/run", str(case["seed"] * 1000 + i)],
                capture_output=True,
                text=True,
                timeout=600,
                check=False,
            )
        codes[str(done.returncode)] = codes.get(str(done.returncode), 0) + 1
        if done.returncode:
            complaints.append(done.stderr[-300:])
    return {"exit codes": codes, "complaints": complaints[:3]}


def summarise(cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Count the processes that did not exit with 0."""
    codes = [case["result"]["exit codes"] for case in cases]
    processes, clean = sum(sum(c.values()) for c in codes), sum(c.get("0", 0) for c in codes)
    return [
        verdict(
            "processes that record a run, read it back and end with exit code 0",
            f"{clean} of {processes}",
            "all of 300",
            clean == processes,
        )
    ]


STUDY = Study(
    name="exits",
    claim="Processes that record a run and read it back end with exit code 0.",
    config={"processes": 30},
    cases=[{"seed": seed} for seed in range(1, 11)],
    run=run,
    summarise=summarise,
    short_cases=[{"seed": 1}],
    short_config={"processes": 3},
)

if __name__ == "__main__":
    STUDY.main()
