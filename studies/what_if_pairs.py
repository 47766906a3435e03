"""Do the pairs of the page's *What if* have the numbers of `compare`?

The page of a living world is asked for pairs in which a share of deer is culled, which runs them in the background;
then `ecs_eco.lab.compare` makes the same change with the same seeds. Both write a page with all numbers.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from studies.common.study import Study, verdict

WORLD = "predator-prey"


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run the pairs and the comparison of one change."""
    from ecs_eco import World
    from ecs_eco.config import load
    from ecs_eco.lab import compare
    from ecs_eco.view.branch import Start
    from ecs_eco.view.live import Live
    from ecs_eco.view.pair import Pair

    at, ticks, seeds = config["at"], config["ticks"], config["seeds"]
    page = Pair(
        Live(World.from_config(load(WORLD), seed=1, record=False)),
        start=Start(["run", WORLD, "--seed", "1", "--ticks", str(ticks)]),
    )
    change = {"kind": "cull", "species": "deer", "share": case["share"]}
    page.handle({"kind": "pairs", "tick": at, "what": change, "seeds": seeds, "ticks": ticks})
    told = dict[str, Any]()
    while not told:
        time.sleep(0.5)
        ended = [one for one in page.news() if one["kind"] == "pairs" and ("html" in one or "problem" in one)]
        told = dict(ended[-1]) if ended else {}
    treated = f'interventions=[{{ at = {at}, kind = "cull", species = "deer", share = {case["share"]} }}]'
    with tempfile.TemporaryDirectory() as place:
        wanted = compare(WORLD, [treated], out=place, seeds=seeds, ticks=ticks, workers=1)
        html = (Path(place) / "compare.html").read_text(encoding="utf-8")
    (effects,) = wanted["effects"].values()
    return {
        "problem": told.get("problem"),
        "runs": [told["done"], told["of"]],
        "equal pages": told.get("html") == html,
        "command": told["command"],
        "lines": told.get("lines", []),
        "numbers": {name: of["mean_number"] for name, of in effects["per_species"].items()},
    }


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return whether both have the same numbers, and what the change does."""
    results = [e["result"] for e in cases]
    equal = sum(r["equal pages"] for r in results)
    says = f"changes for which *What if* and compare write the same page, of {len(cases)}"
    rows = [
        [f"{e['case']['share']:.0%}", name, *map(float, of)]
        for e in cases
        for name, of in e["result"]["numbers"].items()
    ]
    head = ["deer culled", "species", "mean number, change", "low", "high"]
    return {
        "verdicts": [verdict(says, equal, "all", equal == len(cases))],
        "table": {"head": head, "rows": rows},
    }


STUDY = Study(
    name="what_if_pairs",
    claim="The pairs of the page's What if have the numbers of a comparison of the same change.",
    config={"at": 500, "ticks": 1500, "seeds": 20},
    cases=[{"share": 0.5}],
    run=run,
    summarise=summarise,
    short_config={"at": 5, "ticks": 10, "seeds": 2},
)

if __name__ == "__main__":
    STUDY.main()
