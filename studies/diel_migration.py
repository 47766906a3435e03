"""Do copepods migrate, flee and avoid the smell of krill, and what of it is left when one thing is taken away?

Every case is a training seed, a world seed and an arm. All arms but `untrained` live with the same policies, trained in the shipped world;
none is retrained. Depth is followed for the days of the run; escapes and the smell are looked at in the arm `shipped`.
"""

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from _study import Study, verdict

ARMS: dict[str, dict[str, Any]] = {
    "shipped": {}, "untrained": {}, "constant light": {"sun.kind": "constant"}, "inverted light": {"sun.kind": "inverted"},
    "no krill": {"interventions": [{"kind": "cull", "at": 0, "species": "krill", "share": 1.0}]},
}  # fmt: skip
TRAINING_SEEDS, SEEDS = (1, 2, 3, 4), (101, 102, 103, 104)


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Train, or find the policies, and let one world live."""
    from _sea import cycle, escape, plume, trained

    from ecs_eco import World
    from ecs_eco.analysis.migration import follow, p_of_days
    from ecs_eco.config import load

    shipped = load("diel-migration", config["set"])
    policies = "untrained" if case["arm"] == "untrained" else str(trained(shipped, case["training"], config["training_ticks"]))
    here = load(shipped, ARMS[case["arm"]])
    world = World.from_config(here, seed=case["seed"], policies=policies, learn=False)
    assert here.sun is not None
    day = round(here.sun.day / here.dt)
    world.run(day)  # from random depths to their own
    tracks = follow(world, config["days"] * day)
    days = tracks.mean_depth.reshape(config["days"], day)
    out = {**cycle(world, tracks), "p of days": p_of_days(days, n=999) if np.isfinite(days).all() else None, "copepods": world.tables["copepod"].n}
    if case["arm"] == "shipped":
        out |= {"escape": escape(tracks), "plume": plume(here, policies, case["seed"]), "no plume": plume(here, policies, case["seed"], 0.0)}
    return out


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Means over world seeds, then over training seeds, which are the replicates."""
    rows, means = [], {}
    for arm in ARMS:
        mine = [c["result"] for c in cases if c["case"]["arm"] == arm]
        if not mine:
            continue
        vector = np.mean([r["vector"] for r in mine], axis=0)
        means[arm] = {"peak to peak": 2 * float(np.hypot(*vector)), "deeper by day": float(np.mean([r["vector"][0] > 0 for r in mine])),
                      "r": float(np.nanmean([r["r"] for r in mine])) if any(np.isfinite(r["r"]) for r in mine) else float("nan")}
        rows.append([arm, len(mine), *(round(v, 3) for v in means[arm].values()), round(float(np.mean([r["mean depth"] for r in mine])), 1)])
    out = []
    if "shipped" in means:
        own = [c["result"] for c in cases if c["case"]["arm"] == "shipped"]
        out.append(verdict("height of the daily wave of mean depth, as a share of the water, all runs together",
                           round(means["shipped"]["peak to peak"], 3), "at least 0.25", means["shipped"]["peak to peak"] >= 0.25))
        r = [x["r"] for x in own]
        out.append(verdict("correlation of mean depth with light, median over runs", round(float(np.median(r)), 2), "at least 0.6",
                           float(np.median(r)) >= 0.6))
        speed = np.nanmean([x["escape"]["speed"] for x in own], axis=0)
        gain = float(np.nanmax(speed[5:8]) / np.nanmean(speed[:5]))
        out.append(verdict("speed within 2 ticks after a krill comes near, over that before", round(gain, 2), "at least 2", gain >= 2))
        index = [x["plume"]["index"] for x in own if x["plume"]["n"]]
        visits = [x["plume"]["visits"] / max(x["no plume"]["visits"], 1e-9) for x in own]
        out.append(verdict("copepods within 4 m of a smell of krill without a krill, over those at the same places without smell",
                           round(float(np.mean(visits)), 3), "below 1", float(np.mean(visits)) < 1))
        out.append(verdict("chemotaxis index near it, mean over runs with any copepod there", [round(v, 2) for v in index], "above 0",
                           bool(index) and float(np.mean(index)) > 0))
    return {"verdicts": out, "table": {"head": ["arm", "runs", "peak to peak", "deeper by day", "r", "mean depth [m]"], "rows": rows}}


STUDY = Study(
    name="diel_migration",
    claim="Copepods that feel energy alone migrate with the sun, flee what comes near and avoid the smell of krill, in one world with one policy.",
    config={"set": {}, "days": 20, "training_ticks": None},
    cases=[{"arm": arm, "training": t, "seed": s} for t in TRAINING_SEEDS for s in SEEDS for arm in ARMS],
    run=run,
    summarise=summarise,
    short_cases=[{"arm": arm, "training": 1, "seed": 101} for arm in ("shipped", "untrained")],
    short_config={"days": 1, "training_ticks": 60, "set": {"species.copepod.count": 40, "species.phytoplankton.count": 200}},
)

if __name__ == "__main__":
    STUDY.main()
