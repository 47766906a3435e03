"""Which reflex genes spread among goats, depending on learning and inheritance: three kinds of inheritance,
with or without learning, and genes with or without an effect.

The hypotheses are in registered/goats_factorial.toml. Inheritance is one of: "none", where a newborn gets a
random brain; "birth", where its initial weights are genes; "learned", where it copies a parent's current
brain. A gene's coefficient maximizes the likelihood of its path, over the same ticks in all arms.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from studies.common.goats import GENES, carriers, identity, live
from studies.common.registration import registration
from studies.common.selection import mean_interval, path_coefficient, pooled
from studies.common.study import Study, verdict
from studies.inheritance import change

REGISTERED = registration("goats_factorial")
NEWBORN = 10  # ticks of life before learning, which takes place every 32 ticks
# the observations shown to a newborn; all other channels are absent
ASKED = {"touch_yellow": 1.0, "energy": 0.6}
WITH = [name for name, of in REGISTERED.arms.items() if of["genes"]]
TRAITS = 3  # red, yellow and green; blue has no effect in any arm


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run an arm's goats; return coefficients and final shares of genes, and what newborns would eat."""
    of = REGISTERED.arms[case["arm"]]
    changes = change(of["inherit"]) | {"species.goat.policy.learn": of["learn"]}
    if not of["genes"]:
        changes |= silenced(changes)
    asked: list[float] = []
    family = live(
        case["seed"],
        config["ticks"],
        also=changes,
        look=lambda world: asked.extend(eating(world, config["last"], config["ticks"])),
    )
    counts = carriers(family.lineage(), config["every"])
    n, generation, tail = counts["n"], counts["generation"], -max(1, config["last"] // config["every"])
    causes = {c: int((family.lineage().cause == c).sum()) for c in family.world.causes}
    return {
        "s": {g: path_coefficient(counts[g], n, generation, config["mutation"]) for g in GENES},
        "end": {g: float(counts[g][tail:].sum() / max(1, n[tail:].sum())) for g in GENES},
        "n": float(n.mean()),
        "generations": float(generation[n > 0][-1]),
        "extinct": not family.table.n,
        "newborn": len(asked),
        "eat yellow": float(np.mean(asked)) if asked else None,
        "died": {c: k for c, k in causes.items() if k},
    }


def silenced(changes: dict[str, Any]) -> dict[str, Any]:
    """Return changes that remove the effect of the reflex genes."""
    from ecs_eco.config import load

    genes = changes.get("species.goat.genome.genes") or [
        dict(gene) for gene in load("reflexes").species["goat"].genome.model_dump(exclude_none=True)["genes"]
    ]
    mute = [gene | {"values": [0, 0, 0, 0]} if i < TRAITS else gene for i, gene in enumerate(genes)]
    return {"species.goat.genome.genes": mute}


def eating(world: Any, last: int, ticks: int) -> list[float]:
    """Return the probability that each newborn in a run's last ticks eats yellow grass that it touches."""
    from ecs_eco.components import Policy

    goat = world.tables["goat"]
    if world.tick <= ticks - last or not goat.n:
        return []
    rows = goat.by_uid()
    rows = rows[world.tick - goat.born[rows] < NEWBORN]
    minds, channels = goat.species.nerves.individuals, goat.species.nerves.channels
    seen = np.zeros((len(rows), len(channels)), np.float32)
    for name, value in ASKED.items():
        seen[:, channels.index(name)] = value
    if not len(rows):
        return []
    logits, _ = minds.forward(goat[Policy], rows, seen, world.split)
    start, stop = minds.offsets[:2]
    of = list(goat.species.nerves.groups["speed"]).index("eat")
    chances = np.exp(logits[:, start:stop].astype(float))
    return [float(x) for x in chances[:, of] / chances.sum(1)]


def coefficient(results: list[dict[str, Any]], gene: str) -> list[float]:
    """Return the mean over runs of a gene's coefficient and its 95% interval; NaN if no goat carried the
    gene."""
    return mean_interval([r["s"][gene] for r in results if r["s"][gene] is not None])


def gap(of: dict[int, float], than: dict[int, float]) -> list[float]:
    """Return the mean and 95% interval of the differences between two arms, paired by seed."""
    both = sorted(set(of) & set(than))
    over = pooled([of[seed] - than[seed] for seed in both])
    return [over.mean, *over.interval95]


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Test the registered hypotheses; return the verdicts and a table of all arms."""
    arms = {
        name: {e["case"]["seed"]: e["result"] for e in cases if e["case"]["arm"] == name}
        for name in REGISTERED.arms
    }
    arms = {name: runs for name, runs in arms.items() if runs}
    rows = [
        [
            name,
            len(runs),
            sum(r["extinct"] for r in runs.values()),
            np.mean([r["n"] for r in runs.values()]),
            np.mean([r["generations"] for r in runs.values()]),
            *(coefficient(list(runs.values()), g) for g in GENES),
            np.nanmean([r["eat yellow"] or np.nan for r in runs.values()]),
        ]
        for name, runs in arms.items()
        if len(runs) > 1
    ]
    head = [
        "arm",
        "runs",
        "died out",
        "goats",
        "generations",
        *(f"s of {g}" for g in GENES),
        "probability that a newborn eats yellow",
    ]
    whole = len(arms) == len(REGISTERED.arms) and all(len(runs) > 1 for runs in arms.values())
    lines = decided(arms) if whole else []
    lines.append(verdict("arms with two or more finished runs", len(rows), "reported", True))
    return {"verdicts": lines, "table": {"head": head, "rows": rows}}


def decided(arms: dict[str, dict[int, dict[str, Any]]]) -> list[dict[str, Any]]:
    """Return the lines for all hypotheses."""

    def of(name: str, gene: str) -> dict[int, float]:
        return {seed: r["s"][gene] for seed, r in arms[name].items() if r["s"][gene] is not None}

    def newborn(name: str) -> dict[int, float]:
        return {seed: r["eat yellow"] for seed, r in arms[name].items() if r["eat yellow"] is not None}

    s = {(name, g): coefficient(list(arms[name].values()), g) for name in WITH for g in GENES}
    learned, none, frozen = (
        f"{how}, genes" for how in ("learned, learning", "none, learning", "none, frozen")
    )
    low, high = min(s[name, "red"][1] for name in WITH), max(s[name, "green"][2] for name in WITH)
    alone = gap(of(none, "yellow"), of(learned, "yellow"))
    slows = gap(of(frozen, "red"), of(none, "red"))
    habits = gap(newborn("birth, learning, no genes"), newborn("birth, frozen, no genes"))
    return [
        REGISTERED.verdict("red", low, low > 0),
        REGISTERED.verdict("yellow-inherited", s[learned, "yellow"][2], s[learned, "yellow"][2] < 0.05),
        REGISTERED.verdict("yellow-none", alone, alone[1] > 0),
        REGISTERED.verdict("yellow-frozen", s[frozen, "yellow"], s[frozen, "yellow"][1] > 0),
        REGISTERED.verdict("green", high, high < 0),
        REGISTERED.verdict("baldwin-red", slows, slows[1] > 0),
        REGISTERED.verdict("assimilated", habits, habits[2] < 0),
    ]


STUDY = Study(
    name="goats_factorial",
    claim=REGISTERED.content["claim"],
    registered=REGISTERED,
    config={
        "world": "reflexes",
        "identity": identity(),
        "ticks": REGISTERED.content["ticks"],
        "every": 20,
        "last": 1000,
        "mutation": 0.01,
    },
    cases=[
        {"arm": arm, "seed": seed} for seed in REGISTERED.content["seeds"]["world"] for arm in REGISTERED.arms
    ],
    run=run,
    summarise=summarise,
    short_config={"ticks": 300, "last": 200},
    short_cases=[{"arm": arm, "seed": 11001} for arm in ("birth, learning, no genes", "none, frozen, genes")],
)

if __name__ == "__main__":
    STUDY.main()
