"""Does fishing for large fish make small fish (Conover & Munch 2002, Science 297: 94-96)?

Fish of the world data/silversides.toml grow to an adult size that they inherit; without fishing, a weight of 4 g
has the highest fertility. Once a year for 13 years, 30% of the fish are caught; then fishing stops for 13 years, as
in the experiment's second part (Conover, Munch & Arnott 2009, Proc. R. Soc. B 276: 2015-2020).

Arms, with the same seeds:
  largest, smallest, random       the fish that are caught
  none                            no fishing
  largest drawn, smallest drawn   the same catch, but the size of each newborn is drawn at random: not inherited

The experiment had annual fish, all of one age. Here generations overlap, so the largest fish are also the
oldest. The weight of a stock is the geometric mean of the adult weights that the genes of last year's newborns
code for: neither age nor the catch has selected among them. The hypotheses are in
registered/fishing_for_size.toml. It omits that births were also made more frequent after the runs in which
stocks died out, and that the final optimum is as narrow as it was in these.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.registration import registration
from studies.common.study import Study, verdict
from studies.common.training_seeds import interval

REGISTERED = registration("fishing_for_size")
WORLD = Path(__file__).parent / "data" / "silversides.toml"
YEAR = 12  # ticks
BEFORE, AFTER = 5, 18  # years: before the first catch, and when those born after the last catch are counted
CAUGHT = "caught"


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run one arm; return, by year, weights, catches, generations, and selection differentials."""
    from ecs_eco import World
    from ecs_eco.analysis.lineage import Lineage
    from ecs_eco.components import Biology, Body, Stature
    from ecs_eco.config import load
    from ecs_eco.record import Recorder

    built = load(config["world"], REGISTERED.arms[case["arm"]])
    world = World.from_config(built, seed=case["seed"], record=False)
    recorder = Recorder(world, keep_events=True)
    fish, catch = world.table("silverside"), list[tuple[float, float]]()

    def sizes(rows: np.ndarray) -> np.ndarray:
        """Return the weight and the adult weight [g] of fish: f64[2, n]."""
        return 1000 * np.array([fish[Body].mass[rows], fish[Stature].mass[rows]], float)

    def note(_: Any, rows: np.ndarray) -> None:
        caught = rows[[world.causes[cause - 1] == CAUGHT for cause in fish.cause[rows]]]
        catch.extend(zip(*sizes(caught), strict=True))

    world.on_death.append(note)
    weights, yields, differentials = [], [], []
    for year in range(config["ticks"] // YEAR + 1):
        rows = fish.rows()
        young = rows[fish[Biology].age[rows] < YEAR] if year else rows
        weights.append(float(np.exp(np.log(sizes(young)[1]).mean())) if young.size else 0.0)
        before = np.log(sizes(rows)).mean(1)
        world.run(YEAR)
        yields.append(sum(weight for weight, _ in catch))
        if catch:
            differentials.append(np.log(catch).mean(0) - before)
        catch.clear()
    del recorder
    return {
        "fish": fish.n,
        "weight": " ".join(f"{x:.3f}" for x in weights),
        "yield": " ".join(f"{x:.1f}" for x in yields),
        **generations(Lineage.of(world)),
        "caught heavier": np.mean(differentials, axis=0).tolist() if differentials else None,
    }


def generations(lineage: Any) -> dict[str, float]:
    """Return the generations from the newborns of the year before the first catch to those of the year after
    the last, and the mean age of parents in between [ticks]."""
    born, depth = lineage.born, lineage.generation()
    first, last = (depth[(born >= (y - 1) * YEAR) & (born < y * YEAR)] for y in (BEFORE, AFTER))
    between = (born >= BEFORE * YEAR) & (born < AFTER * YEAR) & (lineage.mother >= 0)
    ages = [(born - born[line])[between & (line >= 0)] for line in (lineage.mother, lineage.father)]
    many = first.size and last.size
    return {
        "generations": float(last.mean() - first.mean()) if many else 0.0,
        "generation": float(np.concatenate(ages).mean()),
    }


def by_seed(cases: list[dict[str, Any]], arm: str, name: str) -> dict[int, np.ndarray]:
    """Return the yearly values of an arm's runs, by seed: f64[years]."""
    own = [e for e in cases if e["case"]["arm"] == arm]
    return {e["case"]["seed"]: np.array(e["result"][name].split(), float) for e in own}


def weight(cases: list[dict[str, Any]], arm: str, year: int) -> dict[int, float]:
    """Return an arm's log weight in a year, by seed."""
    return {seed: float(np.log(w[year])) for seed, w in by_seed(cases, arm, "weight").items()}


def catch(cases: list[dict[str, Any]], arm: str, first: int, last: int) -> dict[int, float]:
    """Return the log of an arm's total catch [g] in these years (last exclusive), by seed."""
    return {seed: float(np.log(y[first:last].sum())) for seed, y in by_seed(cases, arm, "yield").items()}


def ratio(one: dict[int, float], other: dict[int, float]) -> list[float]:
    """Return the ratio of two quantities given as logs, paired by seed, and its 95% interval."""
    return [float(round(np.exp(x), 3)) for x in interval([one[seed] - other[seed] for seed in sorted(one)])]


def recovery(cases: list[dict[str, Any]], arm: str) -> list[float]:
    """Return the share of the change in log weight that a pause undoes, and its 95% interval."""
    first, fished, end = (weight(cases, arm, year) for year in (BEFORE, AFTER, -1))
    return interval([(fished[s] - end[s]) / (fished[s] - first[s]) for s in sorted(first)])


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the registered hypotheses, and a table of the arms."""
    last = {arm: weight(cases, arm, AFTER) for arm in REGISTERED.arms}
    late = {arm: catch(cases, arm, AFTER - 3, AFTER) for arm in REGISTERED.arms if arm != "none"}
    early = {arm: catch(cases, arm, BEFORE, BEFORE + 3) for arm in late}
    apart = {s: last["smallest"][s] - last["largest"][s] for s in last["none"]}
    apart_drawn = {s: last["smallest drawn"][s] - last["largest drawn"][s] for s in apart}
    weights, weights_drawn = (
        ratio(last["smallest"], last["largest"]),
        ratio(apart_drawn, dict.fromkeys(apart, 0.0)),
    )
    small, big = ratio(last["largest"], last["none"]), ratio(last["smallest"], last["none"])
    chance, cause = ratio(last["random"], last["none"]), ratio(apart, apart_drawn)
    yields, falls = ratio(late["smallest"], late["largest"]), ratio(late["largest"], early["largest"])
    falls_drawn = ratio(late["largest drawn"], early["largest drawn"])
    undone = [recovery(cases, arm) for arm in ("largest", "smallest")]
    verdicts = [
        REGISTERED.verdict("weight", weights, weights[1] > 2),
        REGISTERED.verdict("largest", small, small[2] < 0.8),
        REGISTERED.verdict("smallest", big, big[1] > 1.25),
        REGISTERED.verdict("random", chance, chance[1] > 0.8 and chance[2] < 1.25),
        REGISTERED.verdict("yield", yields, yields[1] > 1.25),
        REGISTERED.verdict("yield-falls", falls, falls[2] < 0.75),
        REGISTERED.verdict("recovery-largest", undone[0], undone[0][1] > 0 and undone[0][2] < 0.75),
        REGISTERED.verdict("recovery-smallest", undone[1], undone[1][1] > 0 and undone[1][2] < 0.75),
        REGISTERED.verdict("heredity", weights_drawn, weights_drawn[1] > 0.8 and weights_drawn[2] < 1.25),
        REGISTERED.verdict("cause", cause, cause[1] > 1.5),
        REGISTERED.verdict("yield-heredity", falls_drawn, falls_drawn[1] > falls[2]),
    ]
    for arm in ("largest", "smallest"):
        parts = [e["result"]["caught heavier"] for e in cases if e["case"]["arm"] == arm]
        says = (
            f"{arm}: share of the difference in log weight of caught fish that is inherited; the rest is age"
        )
        verdicts.append(verdict(says, interval([own / all_ for all_, own in parts]), "reported", True))
    rows = []
    for arm in REGISTERED.arms:
        own = [e["result"] for e in cases if e["case"]["arm"] == arm]
        heavier = [r["caught heavier"] for r in own if r["caught heavier"] is not None]
        means = np.mean(heavier, axis=0) if heavier else [None, None]
        at = [float(np.exp(np.mean(list(weight(cases, arm, year).values())))) for year in (BEFORE, AFTER, -1)]
        caught = [
            float(np.exp(np.mean(list(of[arm].values()))) / 3) if arm in of else None for of in (early, late)
        ]
        ages = [float(np.mean([r[name] for r in own])) for name in ("generations", "generation")]
        rows.append([arm, f"{sum(r['fish'] > 0 for r in own)} of {len(own)}", *at, *caught, *ages, *means])
    head = ["arm", "stock persists", "weight before [g]", "after the fishery", "after the pause"]
    head += ["catch per year, first 3 [g]", "last 3", "generations of fishing", "mean age of parents [ticks]"]
    head += ["caught less all, log weight", "log adult weight"]
    return {"verdicts": verdicts, "table": {"head": head, "rows": rows}}


STUDY = Study(
    name="fishing_for_size",
    claim=REGISTERED.content["claim"],
    config={"world": tomllib.loads(WORLD.read_text(encoding="utf-8")), "ticks": REGISTERED.content["ticks"]},
    registered=REGISTERED,
    cases=[
        {"arm": arm, "seed": seed} for seed in REGISTERED.content["seeds"]["world"] for arm in REGISTERED.arms
    ],
    run=run,
    summarise=summarise,
    short_cases=[{"arm": arm, "seed": 1} for arm in REGISTERED.arms],
    short_config={"ticks": 216},
)

if __name__ == "__main__":
    STUDY.main()
