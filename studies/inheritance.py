"""What should a newborn goat start with: random weights, its parents' initial weights, or a parent's learned
weights?

The study runs the goats' world in three ways and counts the goats that live to breed. "none": every newborn
draws a random network. "birth": the network's initial weights are genes (three letters each), which cross
over and mutate; weights learned during life are lost at death. "learned": a newborn starts with the current
weights of one of its parents, drawn at random. The study counts goats born after all founders have died, and
early enough to complete their lifespan before the run ends.
"""

from typing import Any

import numpy as np

from studies.common.goats import identity, live
from studies.common.study import Study, verdict

SEEDS = tuple(range(2001, 2009))
BRAIN = {
    "name": "brain",
    "trait": "policy.weights",
    "letters": 3,
    "low": -0.5,
    "high": 0.5,
    "form": "direct",
    "mutation": 0.002,
}
WAYS = ("none", "birth", "learned")
SPAN = 500  # [ticks] a goat's maximum age
ADULT = 100  # [ticks] age at which it can breed
SHARES = ("survive to breeding age", "breed", "breed, of those of breeding age")


def change(way: str) -> dict[str, Any]:
    """Return the changes to the world file for a kind of inheritance."""
    from ecs_eco.config import load

    out: dict[str, Any] = {"species.goat.policy.inherit": way}
    if way == "birth":
        genes = load("reflexes").species["goat"].genome.model_dump(exclude_none=True)["genes"]
        out["species.goat.genome.genes"] = [*genes, BRAIN]
    return out


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one world; return how many goats were born, lived to breeding age and bred, and their causes of
    death."""
    family = live(case["seed"], config["ticks"], also=change(case["inherit"]))
    lineage = family.lineage()
    counted = (
        (lineage.parent > 0) & (lineage.born >= config["from"]) & (lineage.born < config["ticks"] - SPAN)
    )
    age = np.where(lineage.died >= 0, lineage.died, lineage.end) - lineage.born
    adult = counted & (age >= ADULT)
    bred = adult & (np.isin(lineage.uid, lineage.parent) | np.isin(lineage.uid, lineage.parent2))
    first = np.full(len(lineage), np.inf)
    for line in (lineage.mother, lineage.father):
        np.minimum.at(first, line[line >= 0], lineage.born[line >= 0])
    n = lineage.living_sums(lineage.samples(20))
    causes = {
        c: int((lineage.cause[counted] == c).sum())
        for c in family.world.causes
        if (lineage.cause[counted] == c).any()
    }
    waited = float((first - lineage.born)[bred].mean()) if bred.any() else None
    return {
        "born": int(counted.sum()),
        "age at first offspring": waited,
        "adult": int(adult.sum()),
        "bred": int(bred.sum()),
        "age": float(age[counted].mean()) if counted.any() else 0.0,
        "died": causes,
        "extinct": None if family.table.n else int(lineage.died.max()),
        "n": float(n.mean()),
        "least": int(n.min()),
    }


def shares(result: dict[str, Any]) -> dict[str, float]:
    """Return the shares of newborns that lived to breeding age and that bred, and the share of goats reaching
    breeding age that bred."""
    born, adult = max(1, result["born"]), max(1, result["adult"])
    return dict(
        zip(SHARES, (result["adult"] / born, result["bred"] / born, result["bred"] / adult), strict=True)
    )


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the shares with confidence intervals over runs, and how they differ from the arm with learned
    weights."""
    from studies.common.selection import pooled

    by_way = {way: [e["result"] for e in cases if e["case"]["inherit"] == way] for way in WAYS}
    by_way = {way: results for way, results in by_way.items() if results}

    def interval(values: list[float]) -> list[float]:
        over = pooled(values)
        return [over.mean, *over.interval95]

    young = {
        way: [r["age at first offspring"] for r in results if r["age at first offspring"]]
        for way, results in by_way.items()
    }
    share = {
        way: {s: [shares(r)[s] for r in results if r["born"]] for s in SHARES}
        for way, results in by_way.items()
    }
    rows = [
        [
            way,
            len(results),
            sum(r["extinct"] is not None for r in results),
            np.mean([r["n"] for r in results]),
            np.mean([r["born"] for r in results]),
            *(interval(share[way][s]) if share[way][s] else None for s in SHARES),
            interval(young[way]) if young[way] else None,
            causes(results),
        ]
        for way, results in by_way.items()
    ]
    lines = []
    for way in ("none", "birth") if "learned" in share else ():
        for what, of, sign in (
            (f"share of newborns that {SHARES[1]}", {w: share[w][SHARES[1]] for w in share}, 1),
            ("age at first offspring", young, -1),
        ):
            gap = interval([b - a for a, b in zip(of[way], of["learned"], strict=False)] or [0.0])
            met = gap[1] > 0 if sign > 0 else gap[2] < 0
            lines.append(
                verdict(
                    f"{what}: learned minus {way}, paired by seed",
                    gap,
                    "above 0" if sign > 0 else "below 0",
                    met,
                )
            )
        gap = interval(
            [b - a for a, b in zip(share[way][SHARES[0]], share["learned"][SHARES[0]], strict=False)] or [0.0]
        )
        lines.append(
            verdict(
                f"share of newborns that {SHARES[0]}: learned minus {way}, paired by seed",
                gap,
                "reported",
                True,
            )
        )
    lines.append(
        verdict(
            "worlds that die out: " + ", ".join(by_way),
            [sum(r["extinct"] is not None for r in results) for results in by_way.values()],
            "reported",
            True,
        )
    )
    head = [
        "inherited",
        "runs",
        "died out",
        "goats",
        "newborns counted",
        *SHARES,
        "age at first offspring",
        "causes of death",
    ]
    return {"verdicts": lines, "table": {"head": head, "rows": rows}}


def causes(results: list[dict[str, Any]]) -> str:
    """Return the share of each cause of death over all runs, most frequent first."""
    total: dict[str, int] = {}
    for r in results:
        for cause, n in r["died"].items():
            total[cause] = total.get(cause, 0) + n
    return ", ".join(
        f"{c} {n / sum(total.values()):.0%}" for c, n in sorted(total.items(), key=lambda x: -x[1])
    )


STUDY = Study(
    name="inheritance",
    claim="Goats that are born with a parent's learned weights breed more often than goats born with "
    "random or with birth weights.",
    config={"world": "reflexes", "identity": identity(), "ticks": 2500, "from": SPAN, "brain": BRAIN},
    cases=[{"inherit": way, "seed": seed} for way in WAYS for seed in SEEDS],
    run=run,
    summarise=summarise,
    short_cases=[{"inherit": way, "seed": seed} for way in WAYS for seed in SEEDS[:1]],
    short_config={"ticks": 650, "from": 100},
)

if __name__ == "__main__":
    STUDY.main()
