"""Does evolution of the prey change the cycles of prey and predator (Yoshida et al. 2003, Nature 424: 303-306)?

Algae and rotifers live in the chemostat of data/chemostat.toml. A gene of the algae, their wall, makes a share
of bites fail and costs seeds. In the experiment, one clone of algae gave short cycles in which rotifers followed
algae by a quarter of a period; several clones gave long cycles, nearly in antiphase.

Arms, with the same seeds:
  clone   one clone without defense, and no mutation
  clones  four clones; a newborn is of another clone than its parent with a probability of 0.0004
  drawn   the same four clones, but the clone of each newborn is drawn at random: the same variation, not inherited

Before the world was written, the mean field was explored: two to eight clones with logistic growth and a
saturating intake. It cycles with a lag near 1/4 for one clone, and with two to four times the period and a lag
of 0.35 to 0.5 for several, where outflow is 0.1 to 0.3 of maximum growth and the toughest clone loses at least 0.9
of bites and 0.2 to 0.5 of growth; high mutation rates and clones drawn at birth stop the cycles. The hypotheses are
in registered/rapid_evolution.toml; it counts 26 exploratory runs before the last, but there were 35.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.registration import registration
from studies.common.study import Study, verdict

REGISTERED = registration("rapid_evolution")
WORLD = Path(__file__).parent / "data" / "chemostat.toml"
SEEDS = REGISTERED.content["seeds"]["world"]
ANTIPHASE = 0.375  # a lag nearer to 1/2 than to 1/4
EVERY = 5  # ticks between the numbers that are stored


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run one arm; return its cycles, deaths by cause, and numbers every few ticks."""
    from ecs_eco import World
    from ecs_eco.analysis.cycles import cycle_statistics
    from ecs_eco.analysis.runs import load_series
    from ecs_eco.components import Defence
    from ecs_eco.config import load

    world = World.from_config(load(config["world"], REGISTERED.arms[case["arm"]]), seed=case["seed"])
    algae, walls, eaten, choice = world.tables["alga"], [], list[float](), list[float]()

    def note(table: Any, rows: np.ndarray) -> None:
        if table is algae:
            of = [row for row in rows if world.causes[table.cause[row] - 1] == "eaten by rotifer"]
            eaten.extend(table[Defence].toughness[of].astype(float))

    world.on_death.append(note)
    for _ in range(config["ticks"] // EVERY):
        before = algae[Defence].toughness[algae.rows()].astype(float)
        world.run(EVERY)
        if eaten and before.size:  # without choice, an alga is eaten as often as bites succeed
            choice.append(float(np.mean(eaten) - np.average(before, weights=1.001 - before)))
        eaten.clear()
        rows = algae.rows()
        walls.append(float(algae[Defence].toughness[rows].mean()) if rows.size else 0.0)
    series = load_series(world.series(), ("alga", "rotifer"))
    cycles = cycle_statistics(series, period_of=["rotifer"])
    peak, lag = cycles.peaks.get("rotifer"), cycles.lags.get("alga→rotifer")
    table = world.series().to_pydict()
    rotifers = np.array(table["species"]) == "rotifer"
    return {
        "persists": bool(series.n[-1].all()),
        "cycles": "rotifer" in cycles.cycling(),
        "period": cycles.period,
        "peaks": None if peak is None else peak.held,
        "lag": None if lag is None else lag.share,
        "swings": [float(np.log10(1 + x[len(x) // 10 :]).std()) for x in series.n.T],
        "starved": share_of(np.array(table["died: starved"])[rotifers], np.array(table["deaths"])[rotifers]),
        "choice": float(np.mean(choice)) if choice else 0.0,  # wall of eaten algae, minus without choice
        "wall": line(np.array(walls), 3),
        "alga": line(series.n[EVERY - 1 :: EVERY, 0], 0),
        "rotifer": line(series.n[EVERY - 1 :: EVERY, 1], 0),
    }


def share_of(part: np.ndarray, whole: np.ndarray) -> float:
    """Return the sum of a part, divided by the sum of the whole."""
    return float(part.sum() / max(1, whole.sum()))


def line(values: np.ndarray, digits: int) -> str:
    """Return numbers as one line of text."""
    return " ".join(f"{value:.{digits}f}" for value in values)


def measures(cases: list[dict[str, Any]], arm: str, name: str) -> dict[int, float]:
    """Return a measure of an arm's runs by seed, without runs in which it is unknown."""
    of = {e["case"]["seed"]: e["result"][name] for e in cases if e["case"]["arm"] == arm}
    return {seed: value[1] if name == "swings" else value for seed, value in of.items() if value is not None}


def gap(cases: list[dict[str, Any]], name: str, one: str, other: str, scale: Any = float) -> list[float]:
    """Return the mean difference of a measure between two arms, paired by seed, and its 95% t interval."""
    from studies.common.training_seeds import interval

    a, b = measures(cases, one, name), measures(cases, other, name)
    return interval([scale(a[seed]) - scale(b[seed]) for seed in sorted(a.keys() & b.keys())])


def antiphase(cases: list[dict[str, Any]], arm: str) -> int:
    """Return the number of runs whose rotifers cycle with a lag nearer to 1/2 than to 1/4."""
    lags, cycles = measures(cases, arm, "lag"), measures(cases, arm, "cycles")
    return sum(bool(cycles[seed]) and ANTIPHASE < lag < 1 - ANTIPHASE for seed, lag in lags.items())


def median_lag(cases: list[dict[str, Any]], arm: str) -> list[float]:
    """Return the median lag of rotifers behind algae [periods] over seeds, and its 95% interval."""
    from ecs_eco.analysis.cycles import median_lag_interval

    of = median_lag_interval(list(measures(cases, arm, "lag").values()))
    return [round(of[key], 3) for key in ("median", "low", "high")]


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the registered hypotheses, and a table of the arms."""
    alive = sum(sum(measures(cases, arm, "persists").values()) for arm in REGISTERED.arms)
    ratio = [float(round(np.exp(x), 2)) for x in gap(cases, "period", "clones", "clone", np.log)]
    one, many = median_lag(cases, "clone"), median_lag(cases, "clones")
    later, swing = gap(cases, "lag", "clones", "clone"), gap(cases, "swings", "clones", "drawn")
    evolving, drawn = antiphase(cases, "clones"), antiphase(cases, "drawn")
    verdicts = [
        REGISTERED.verdict("persist", alive, alive >= 27),
        REGISTERED.verdict("period", ratio, ratio[1] > 1.5),
        REGISTERED.verdict("lag-clone", one, one[1] > 0.15 and one[2] < 0.35),
        REGISTERED.verdict("lag-clones", many, many[1] > ANTIPHASE and many[2] < 1 - ANTIPHASE),
        REGISTERED.verdict("later", later, later[1] > 0.05),
        REGISTERED.verdict("cycles", evolving, evolving >= 8),
        REGISTERED.verdict("heredity", drawn, drawn <= 2),
        REGISTERED.verdict("swing", swing, swing[1] > 0.05),
    ]
    for arm in ("clones", "drawn"):
        walls = [np.array(e["result"]["wall"].split(), float) for e in cases if e["case"]["arm"] == arm]
        of = np.mean([np.quantile(x[len(x) // 10 :], [0.05, 0.95]) for x in walls], axis=0).round(2)
        verdicts.append(
            verdict(f"{arm}: mean share of bites that fail, 5% and 95% of ticks", list(of), "reported", True)
        )
    rows = []
    for arm in REGISTERED.arms:
        own = [e["result"] for e in cases if e["case"]["arm"] == arm]
        periods = list(measures(cases, arm, "period").values())
        rows.append(
            [
                arm,
                f"{sum(r['persists'] for r in own)} of {len(own)}",
                f"{sum(r['cycles'] for r in own)} of {len(own)}",
                float(np.median(periods)) if periods else None,
                *([value] if (value := median_lag(cases, arm)[0]) == value else [None]),
                *(float(np.mean([r["swings"][i] for r in own])) for i in (0, 1)),
                float(np.mean([r["starved"] for r in own])),
            ]
        )
    head = ["arm", "both persist", "rotifers cycle", "median period [ticks]", "median lag [periods]"]
    head += ["swing of algae [log10]", "swing of rotifers [log10]", "share of rotifer deaths by starvation"]
    return {"verdicts": verdicts, "table": {"head": head, "rows": rows}}


STUDY = Study(
    name="rapid_evolution",
    claim=REGISTERED.content["claim"],
    config={"world": tomllib.loads(WORLD.read_text(encoding="utf-8")), "ticks": REGISTERED.content["ticks"]},
    registered=REGISTERED,
    cases=[{"arm": arm, "seed": seed} for seed in SEEDS for arm in REGISTERED.arms],
    run=run,
    summarise=summarise,
    short_cases=[{"arm": arm, "seed": 1} for arm in REGISTERED.arms],
    short_config={"ticks": 150},
)

if __name__ == "__main__":
    STUDY.main()
