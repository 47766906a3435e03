"""Whose policy determines whether a world persists: the deer's or the wolves'?

The study swaps deer and wolves between two training seeds whose worlds go extinct under the earlier recipe
(studies/protocols.py) and two whose worlds persist: every deer policy meets every wolf policy, in a world
with half the area. The seeds were chosen by their outcomes, and there is only one world seed: the study shows
whose policy determines the outcome in these cases, but not how often or why. It did not measure how well deer
evade.
"""

from typing import Any

import numpy as np

from studies.common.predator_prey import frozen
from studies.common.seed_grid import live, policies_of, record
from studies.common.study import Study, verdict
from studies.protocols import HALF, OLD

DIE, LIVE, WORLD = (3, 32), (21, 22), 6101


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one training seed's deer with another's wolves."""

    of = {
        s: str(policies_of({**config, "world": "predator-prey"}, {"train": config["train"]}, case[s]))
        for s in ("deer", "wolf")
    }
    world = frozen(config["life"])
    ending = record(live(world, case["seed"], of, config["ticks"], False), world)
    return {k: ending[k] for k in ("persisted", "lived", "extinct", "numbers", "deaths")}


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the shares of the variance in survival time explained by the deer's seed and by the wolves'
    seed."""

    def share(species: str, seeds: tuple[int, ...]) -> tuple[int, int]:
        mine = [c["result"]["persisted"] for c in cases if c["case"][species] in seeds]
        return sum(mine), len(mine)

    out = [
        verdict(
            f"worlds that persist with {whose} from seeds whose worlds {word}",
            "{} of {}".format(*share(species, seeds)),
            "reported",
            True,
        )
        for species, whose in (("deer", "deer"), ("wolf", "wolves"))
        for word, seeds in (("die", DIE), ("persist", LIVE))
    ]
    lived = np.array(
        [
            [
                next(
                    (c["result"]["lived"] for c in cases if (c["case"]["deer"], c["case"]["wolf"]) == (d, w)),
                    np.nan,
                )
                for w in DIE + LIVE
            ]
            for d in DIE + LIVE
        ]
    )
    if np.isfinite(lived).all():
        total = ((lived - lived.mean()) ** 2).sum()
        by = {
            name: lived.shape[1 - i] * ((lived.mean(1 - i) - lived.mean()) ** 2).sum() / total
            for i, name in enumerate(("deer", "wolf"))
        }
        out.append(
            verdict(
                "share of the variance in lifetime explained by the deer's seed, and by the wolves' seed",
                [float(by["deer"]), float(by["wolf"])],
                "larger for the deer's seed",
                by["deer"] > by["wolf"],
            )
        )
    rows = [
        [
            c["case"]["deer"],
            c["case"]["wolf"],
            c["result"]["lived"],
            c["result"]["extinct"] or "–",
            *(c["result"]["numbers"][s]["least"] for s in ("grass", "deer", "wolf")),
        ]
        for c in cases
    ]
    return {
        "verdicts": out,
        "table": {
            "head": [
                "deer from seed",
                "wolves from seed",
                "lifetime [ticks]",
                "died out",
                "fewest grass plants",
                "fewest deer",
                "fewest wolves",
            ],
            "rows": rows,
        },
    }


STUDY = Study(
    name="swapped",
    claim="Among four training seeds chosen by their worlds' fate, "
    "the deer's seed explains more of that fate than the wolves' seed.",
    config={"train": OLD, "life": HALF, "ticks": 8000, "short training": None},
    cases=[{"deer": d, "wolf": w, "seed": WORLD} for d in DIE + LIVE for w in DIE + LIVE],
    run=run,
    summarise=summarise,
    short_cases=[{"deer": 3, "wolf": 21, "seed": WORLD}],
    short_config={"ticks": 300, "short training": 100},
)

if __name__ == "__main__":
    STUDY.main()
