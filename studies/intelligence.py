"""Does learning evolve where the past of a life predicts the present better than the past of the line?

Foragers of the world data/foragers.toml choose between two places, of which one is good. It changes during life
(probability `within` per tick) and between generations (`between`), after Dunlap & Stephens (2009, Proc. R. Soc.
B 276: 3201-3208) and Mery & Kawecki (2002, PNAS 99: 14274-14279). They inherit a network, its number of hidden
units and the learning rate of their PPO; hidden units and learning cost energy.

Arms, with the same seeds:
  map                              5 values of `within` x 5 of `between`
  no cost, prohibitive, off, shuffled
                                   three cells; free or costly learning; none; genes from random living members
  hunters frozen, evolve, learn    other animals as the environment: a place is worth the proportion of hunters
                                   that wait at the other one

An evolved learning rate is the mean of log10(learning rate + 0.001) over the animals of the last third of a
run. The hypotheses are in registered/intelligence.toml.
"""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.registration import registration
from studies.common.study import Study, verdict
from studies.common.training_seeds import interval

REGISTERED = registration("intelligence")
WORLD = Path(__file__).parent / "data" / "foragers.toml"
WITHIN, BETWEEN = REGISTERED.content["within"], REGISTERED.content["between"]
LIFE, LINE, NEITHER = (0.0, 0.5), (0.0, 0.0), (0.5, 0.5)  # which past is informative: (within, between)
CONTROLS = ("no cost", "prohibitive", "off", "shuffled")
HUNTED = ("hunters frozen", "hunters evolve", "hunters learn")
LEARNS = 40  # ticks; after them, animals with a learning rate of 0.1 chose well in 88% of ticks
DEATH, OLDEST = 0.008, 300  # per tick; ticks
EVERY = 50  # ticks between two measurements
FIRST = [seeds[0] for seeds in (REGISTERED.content["seeds"]["world"], REGISTERED.content["seeds"]["hunted"])]
Cell = tuple[float, float]
BySeed = dict[int, float]


def pasts(within: float, between: float) -> tuple[float, float]:
    """Return the correlation of the good place now with the one LEARNS ticks ago, and its mean correlation over
    the ages of living animals with the one at the mother's birth."""
    ages = np.arange(OLDEST)
    living = (1 - DEATH) ** ages
    lasts = float((living * (1 - 2 * within) ** ages).sum() / living.sum())
    return float((1 - 2 * within) ** LEARNS), (1 - 2 * between) * lasts


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run one case; return means over the last third of its ticks."""
    from ecs_eco import World
    from ecs_eco.components import LearningRates, NeuralCost, Traits
    from ecs_eco.config import load

    changes = dict(REGISTERED.arms[case["arm"]])
    controls = changes.pop("controls", [])
    changes |= {f"systems.Forage.{key}": case[key] for key in ("within", "between")}
    world = World.from_config(
        load(WORLD, changes), seed=case["seed"], controls=controls, trust=True, record=False
    )
    foragers = world.table("forager")
    food = next(columns for kind, columns in foragers.columns.items() if kind.__name__ == "Food")
    measured = []
    for tick in range(EVERY, config["ticks"] + 1, EVERY):
        world.run(EVERY)
        if tick > config["ticks"] * 2 / 3 and foragers.n:
            rows, costs = foragers.rows(), foragers[NeuralCost]
            rates = foragers[LearningRates].learning_rate[rows].astype(float)
            units = foragers[Traits].value[rows, foragers.species.traits["policy.hidden.0"]]
            measures = foragers.n, np.log10(rates + 0.001), units, food.worth[rows], costs.learning[rows]
            measured.append([float(np.mean(of_all)) for of_all in measures])
    names = ("foragers", "rate", "units", "worth", "learning")
    gone = [0.0, -3.0, 0.0, 0.0, 0.0]  # no learning, if no forager is left
    means = np.mean(measured or [gone], axis=0).tolist()
    hunters = world.table("hunter").n
    return {name: round(x, 6) for name, x in zip(names, means, strict=True)} | {"hunters": hunters}


def values(cases: list[dict[str, Any]], arm: str, cell: Cell, name: str = "rate") -> BySeed:
    """Return a result of an arm's runs in one cell of the map, by seed."""
    wanted = {"arm": arm, "within": cell[0], "between": cell[1]}
    own = [e for e in cases if {key: e["case"][key] for key in wanted} == wanted]
    return {e["case"]["seed"]: e["result"][name] for e in own}


def minus(one: BySeed, other: BySeed) -> BySeed:
    """Return the differences between two results with the same seeds."""
    return {seed: one[seed] - other[seed] for seed in sorted(one.keys() & other.keys())}


def effect(cases: list[dict[str, Any]], arm: str) -> BySeed:
    """Return, by seed, the learning rate at LIFE minus the mean of those at LINE and NEITHER."""
    life, line, neither = (values(cases, arm, cell) for cell in (LIFE, LINE, NEITHER))
    return {seed: life[seed] - (line[seed] + neither[seed]) / 2 for seed in sorted(life)}


def of_map(
    cases: list[dict[str, Any]], name: str, statistic: Callable[[np.ndarray, np.ndarray], float]
) -> BySeed:
    """Return, by seed, a statistic of the map of a result and both pasts f64[25, 2]."""
    cells = [(within, between) for within in WITHIN for between in BETWEEN]
    known = np.array([pasts(*cell) for cell in cells])
    found = [values(cases, "map", cell, name) for cell in cells]
    return {seed: statistic(np.array([of[seed] for of in found]), known) for seed in sorted(found[0])}


def order(rates: np.ndarray, known: np.ndarray) -> float:
    """Return Spearman's correlation of learning rates f64[cells] with the pasts' difference, life minus line."""
    return correlation(rates, known[:, 0] - known[:, 1])


def size(units: np.ndarray, known: np.ndarray) -> float:
    """Return Spearman's correlation of hidden units f64[cells] with what the line predicts."""
    return correlation(units, known[:, 1])


def sign(rates: np.ndarray, known: np.ndarray) -> float:
    """Return the mean learning rate where life predicts more by at least 0.25, minus the mean of the others."""
    more = known[:, 0] - known[:, 1] >= 0.25
    return float(rates[more].mean() - rates[~more].mean())


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Return Spearman's rank correlation."""
    from scipy.stats import spearmanr

    return float(spearmanr(a, b).statistic)


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the registered hypotheses, and a table of the cells and arms."""
    lines, main = [], effect(cases, "map")
    frozen, evolve, learn = (values(cases, arm, LINE) for arm in HUNTED)
    tested = {
        "order": of_map(cases, "rate", order),
        "sign": of_map(cases, "rate", sign),
        "line": minus(values(cases, "map", LIFE), values(cases, "map", LINE)),
        "life": minus(values(cases, "map", LIFE), values(cases, "map", NEITHER)),
        "brain": of_map(cases, "units", size),
        "cost": minus(values(cases, "no cost", LINE), values(cases, "map", LINE)),
        "learned": minus(values(cases, "map", LIFE, "worth"), values(cases, "off", LIFE, "worth")),
        **{control: minus(main, effect(cases, control)) for control in CONTROLS},
        "conjecture": minus(learn, evolve),
    }
    for name, by_seed in tested.items():
        value = interval(list(by_seed.values()))
        lines.append(REGISTERED.verdict(name, value, value[1] > REGISTERED.hypotheses[name]["margin"]))
    against = interval(list(minus(learn, frozen).values()))
    lines.append(verdict("hunters that learn minus frozen hunters: learning rate", against, "reported", True))
    rows = []
    for arm, within, between in dict.fromkeys(tuple(e["case"].values())[:3] for e in cases):
        names = ("rate", "units", "worth", "learning", "foragers")
        own = [list(values(cases, arm, (within, between), name).values()) for name in names]
        rows.append([arm, within, between, *pasts(within, between), *map(float, np.mean(own, axis=1))])
    head = [
        "arm",
        "changes per tick",
        "changes per generation",
        "what life predicts",
        "what the line predicts",
    ]
    head += ["log10(learning rate + 0.001)", "hidden units", "share of good choices", "energy for learning"]
    return {"verdicts": lines, "table": {"head": [*head, "foragers"], "rows": rows}}


def every_case() -> list[dict[str, Any]]:
    """Return all cases: the map, its controls, and hunters."""
    cells = [("map", (within, between)) for within in WITHIN for between in BETWEEN]
    cells += [(arm, cell) for arm in CONTROLS for cell in (LIFE, LINE, NEITHER)]
    seeds = REGISTERED.content["seeds"]
    grid = [(*of, seed) for of in cells for seed in seeds["world"]]
    grid += [(arm, LINE, seed) for arm in HUNTED for seed in seeds["hunted"]]
    return [{"arm": a, "within": w, "between": b, "seed": seed} for a, (w, b), seed in grid]


STUDY = Study(
    name="intelligence",
    claim=REGISTERED.content["claim"],
    config={
        "world": tomllib.loads(WORLD.read_text(encoding="utf-8")),
        "code": hashlib.sha256(WORLD.with_suffix(".py").read_bytes()).hexdigest(),
        "ticks": REGISTERED.content["ticks"],
    },
    registered=REGISTERED,
    cases=every_case(),
    run=run,
    summarise=summarise,
    short_cases=[case | {"seed": 1} for case in every_case() if case["seed"] in FIRST],
    short_config={"ticks": 100},
)

if __name__ == "__main__":
    STUDY.main()
