"""Do an intervention in a world file and the same intervention in a fork give the same bytes?

The interventions remove half the wolves, double the deer's birth rate, or build a fence.
"""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.predator_prey import frozen
from studies.common.runs import content
from studies.common.study import Study, verdict

DONE = {
    "half of the wolves": {"kind": "cull", "species": "wolf", "share": 0.5},
    "twice the births of deer": {"kind": "set", "set": {"species.deer.reproduction.rate": 0.028}},
    "a fence across the world": {"kind": "fence", "region": [60.0, 60.0, 180.0, 180.0]},
}


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Intervene at a tick through the file and through a fork; compare worlds and recordings with each
    other and with an unchanged world."""
    from ecs_eco.analysis.report import write_report
    from ecs_eco.analysis.runs import load_series
    from ecs_eco.record import fork, run_to_folder

    at, until, seed, done = (
        config["at"],
        config["until"],
        case["seed"],
        DONE[case["what"]] | {"at": config["at"]},
    )
    with tempfile.TemporaryDirectory() as place:
        here = Path(place)
        alone = run_to_folder(
            frozen(), seed=seed, ticks=until, out=here / "alone", report=False, checkpoint_every=at, keep=99
        )
        planned = run_to_folder(
            frozen({"interventions": [done]}), seed=seed, ticks=until, out=here / "planned", report=False
        )
        changes = done["set"] if done["kind"] == "set" else {"interventions": [done]}
        forked = fork(here / "alone", here / "fork", from_tick=at, changes=changes, report=False)
        write_report(here / "planned")
        page = (here / "planned" / "report.html").read_text(encoding="utf-8")
        numbers = {name: load_series(here / name).n for name in ("alone", "planned", "fork")}
        same_rows = bool(np.array_equal(numbers["planned"][at:], numbers["fork"]))
        recorded = content(here / "planned") != content(here / "alone")
    return {
        "alone": alone["digest"],
        "planned in the file": planned["digest"],
        "set in a fork": forked["digest"],
        "same numbers afterward": same_rows,
        "recording differs": recorded,
        "marked in the report": "ntervention" in page,
        "numbers at the end, without and with it": [
            numbers["alone"][-1].tolist(),
            numbers["planned"][-1].tolist(),
        ],
    }


def summarise(cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Count equal results."""
    results, n = [c["result"] for c in cases], len(cases)
    same = sum(
        r["planned in the file"] == r["set in a fork"] and r["same numbers afterward"] for r in results
    )
    other, marked = (
        sum(r["planned in the file"] != r["alone"] for r in results),
        sum(r["marked in the report"] for r in results),
    )
    what = ", ".join(sorted({c["case"]["what"] for c in cases}))
    return [
        verdict(
            f"runs in which the file and the fork end with the same bytes ({what})",
            f"{same} of {n}",
            f"{n}",
            same == n,
        ),
        verdict(
            "runs that differ from a run without the intervention", f"{other} of {n}", f"{n}", other == n
        ),
        verdict("reports that mark the intervention", f"{marked} of {n}", f"{n}", marked == n),
    ]


STUDY = Study(
    name="interventions",
    claim="An intervention in the world file and the same intervention in a fork of a checkpoint give the "
    "same bytes.",
    config={"at": 400, "until": 800},
    cases=[{"what": what, "seed": seed} for what in DONE for seed in (41, 42)],
    run=run,
    summarise=summarise,
    short_config={"at": 20, "until": 30},
    short_cases=[{"what": what, "seed": 41} for what in DONE],
)

if __name__ == "__main__":
    STUDY.main()
