"""Search for a meadow in which goats and all other species persist for 50,000 ticks.

The search starts from the `reflexes` world with grass that grows so slowly that goats go extinct within 2,000
ticks. The search may change six parameters of green grass and goats; the best world and the initial world are
confirmed on fresh world seeds. The study takes about 15 minutes on one core, and an interrupted search can be
resumed.
"""

import hashlib
import tempfile
from pathlib import Path
from typing import Any

from studies.common.study import Study, canonical, verdict

POOR = {"species.green.reproduction.seed_rain": 0.0003, "species.green.reproduction.rate": 0.002}
RANGES = {
    "species.green.reproduction.seed_rain": {"search": [0.0002, 0.003], "scale": "log"},
    "species.green.reproduction.rate": {"search": [0.001, 0.01], "scale": "log"},
    "species.goat.diet.2.gain": [0.06, 0.2],
    "species.goat.metabolism.basal": {"search": [0.001, 0.004], "scale": "log"},
    "species.goat.reproduction.energy_given": [0.2, 0.5],
    "species.goat.reproduction.rest": [20.0, 150.0],
}
SEARCH = {
    "objective": "persistence",
    "ticks": 5000,
    "world_seeds": 2,
    "confirm": {"world_seeds": 4, "training_seeds": 1, "ticks": 50_000},
}


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one search; return the best world's parameters and the confirmation."""
    from ecs_eco.config import load
    from ecs_eco.lab import search

    asked = canonical(config) + load("reflexes").config_hash  # a search resumes only in the same world
    name = hashlib.sha256(asked.encode()).hexdigest()[:12]
    out = Path(tempfile.gettempdir()) / f"ecs-eco-goats-{name}"
    wanted = {
        **config["start"],
        **{f"search.{k}": v for k, v in config["search"].items()},
        "search.seed": case["seed"],
        **{f'search.ranges."{k}"': v for k, v in config["ranges"].items()},
    }
    result = search("reflexes", out, wanted, trials=config["trials"], workers=2, report=config["report"])
    return {k: result[k] for k in ("candidates", "by_stage", "seconds", "start", "best", "confirmation")}


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the best and initial worlds' persistence on fresh seeds."""
    result = cases[0]["result"]
    best, start = result["confirmation"]["best"], result["confirmation"]["start"]
    ticks = f"{SEARCH['confirm']['ticks']:,}"
    out = [
        verdict(
            "as written: share of runs on fresh seeds in which all species persist",
            f"{start['persisted']} of {start['runs']}",
            "none",
            start["persisted"] == 0,
        ),
        verdict(
            f"best candidate: runs of {ticks} ticks on fresh seeds in which all species persist",
            f"{best['persisted']} of {best['runs']}",
            "all",
            best["persisted"] == best["runs"],
        ),
    ]
    numbers = result["best"][0]["values"]
    return {
        "verdicts": out,
        "table": {
            "head": ["parameter", "as written", "found"],
            "rows": [[k, result["start"].get(k), v] for k, v in numbers.items()],
        },
    }


STUDY = Study(
    name="goats_persist",
    claim="A search turns a meadow in which goats die out into one in which they persist.",
    config={"start": POOR, "ranges": RANGES, "search": SEARCH, "trials": 20, "report": True},
    cases=[{"seed": 1}],
    run=run,
    summarise=summarise,
    short_cases=[{"seed": 1}],
    short_config={
        "trials": 1,
        "report": False,
        "search": {
            **SEARCH,
            "ticks": 40,
            "world_seeds": 1,
            "confirm": {"world_seeds": 1, "training_seeds": 1, "ticks": 40},
        },
    },
)

if __name__ == "__main__":
    STUDY.main()
