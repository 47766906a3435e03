"""Which numbers let grass, deer and wolves live together and cycle? A random search around the shipped world.

Each candidate draws its numbers from the ranges below, meets the policies of two training seeds (trained in the shipped world)
on a world seed each, and is given up at its first extinction: most die early and cost little. The shipped numbers were found
by such searches, whose ranges moved with what the causes of death told; this is the form to begin one's own with.
"""

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from _predator_prey import first_extinction, identity, live, numbers, trained
from _study import Study, verdict

RANGES: dict[str, list[float]] = {
    "species.wolf.reproduction.spacing": [7.0, 8.5, 10.0, 12.0],
    "species.wolf.reproduction.rate": [0.0045, 0.007, 0.01],
    "species.wolf.diet.0.gain": [0.35, 0.4, 0.46, 0.55],
    "species.deer.reproduction.rate": [0.011, 0.014, 0.018],
    "species.deer.diet.0.chance": [0.15, 0.2, 0.4],
    "species.grass.reproduction.rate": [0.025, 0.034, 0.05],
}


def drawn(candidate: int) -> dict[str, float]:
    """The numbers of a candidate; candidate 0 is the world as it is shipped."""
    generator = np.random.Generator(np.random.Philox(key=[1, candidate]))
    return {k: float(generator.choice(v)) for k, v in RANGES.items()} if candidate else {}


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Let one candidate live; return how long, who died out first, and how it cycled."""
    from ecs_eco.analysis.cycles import cycle_statistics
    from ecs_eco.config import load

    shipped = load(config["world"])
    world = load(config["world"], drawn(case["candidate"]))
    lived, out = [], {"numbers": drawn(case["candidate"])}
    for training, seed in config["policies"]:
        world_run = live(world, seed, str(trained(shipped, training, config["training_ticks"])), config["ticks"])
        when, who = first_extinction(numbers(world_run))
        lived.append(when)
        if who is not None:
            return out | {"lived": lived, "extinct": who}
        c = cycle_statistics(world_run.series(), n_boot=199)
        out[f"training seed {training}"] = {"period": c.period, "p_ar1": c.p_ar1, "cycling": list(c.cycling())}
    return out | {"lived": lived, "extinct": None}


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Rank the candidates by how long they lived, then by how many species cycle."""
    def score(result: dict[str, Any]) -> tuple[int, int]:
        return sum(result["lived"]), sum(len(v["cycling"]) for k, v in result.items() if k.startswith("training seed"))

    ranked = sorted(cases, key=lambda c: score(c["result"]), reverse=True)
    kept = sum(c["result"]["extinct"] is None for c in cases)
    rows = [[c["case"]["candidate"], *score(c["result"]), c["result"]["extinct"] or "none", *(c["result"]["numbers"].get(k, "as shipped") for k in RANGES)]
            for c in ranked[:20]]  # fmt: skip
    head = ["candidate", "ticks lived", "species that cycle", "extinct first", *(k.removeprefix("species.") for k in RANGES)]
    return {"verdicts": [verdict("candidates in which all persist with the policies of both training seeds", f"{kept} of {len(cases)}", "at least 1", kept > 0)],
            "table": {"head": head, "rows": rows}}  # fmt: skip


STUDY = Study(
    name="search_predator_prey", claim="A random search finds numbers with which grass, deer and wolves persist and cycle.",
    config={"world": "predator-prey", "identity": identity(policies=False), "ranges": RANGES, "ticks": 6000, "training_ticks": None,
            "policies": [[1, 100], [2, 101]]},
    cases=[{"candidate": i} for i in range(41)], run=run, summarise=summarise, short_cases=[{"candidate": 0}],
    short_config={"ticks": 600, "training_ticks": 300, "policies": [[1, 100]]},
)  # fmt: skip

if __name__ == "__main__":
    STUDY.main()
