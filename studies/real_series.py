"""Are shipped worlds' cycles like measured cycles (lynx and hares, wolves and moose, mites, protozoa)?

The hypotheses, and the criterion by which a pair resembles a world, are in registered/real_series.toml. Each
world runs with seeds that no other study uses; its series are cut into windows with the same length (in
periods) and sampling frequency as a measured series. `python -m studies.draw_real_series` draws the figure
from the result.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.registration import registration
from studies.common.study import Study, verdict

REGISTERED = registration("real_series")
DATA = Path(__file__).parent / "data"
SERIES: dict[str, dict[str, str]] = REGISTERED.content["series"]
MEASURES: list[str] = REGISTERED.content["statistic"]["measures"]
PAIRS = {"predator-prey": [("deer", "wolf"), ("grass", "deer")], "island": [("deer", "wolf")]}
BLOCK = 5  # ticks averaged into each stored mean


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run a world; return its numbers as means over blocks of ticks, one line per species."""
    from ecs_eco import World
    from ecs_eco.analysis.runs import load_series
    from studies.common.goats import text

    world = World.from_config(case["arm"], seed=case["seed"], learn=False)
    names = sorted({name for pair in PAIRS[case["arm"]] for name in pair})
    while world.tick < config["ticks"] and all(world.tables[name].n for name in names):
        world.run(min(250, config["ticks"] - world.tick))
    series = load_series(world.series())
    n = {name: series.n[:, series.index(name)] for name in names}
    length = len(series.n) // BLOCK * BLOCK
    return {
        "lived": world.tick,
        "numbers": {name: text(x[:length].reshape(-1, BLOCK).mean(1)) for name, x in n.items()},
    }


def measured(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return a measured pair's prey and predator series: f64[samples] each."""
    of = SERIES[name]
    with open(DATA / of["file"], encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if "treatment" in of:
        mine = [row for row in rows if row["Treatment"] == of["treatment"]]
        both = [
            [float(row["Individuals"] or "nan") for row in mine if row["Species"].startswith(kind)]
            for kind in ("Prey", "Predator")
        ]
    else:
        both = [[float(row[of[kind]] or "nan") for row in rows] for kind in ("prey", "predator")]
    prey, predator = longest(np.array(both).T).T
    return prey, predator


def longest(rows: np.ndarray) -> np.ndarray:
    """Return the longest stretch of rows without missing numbers."""
    whole = np.concatenate([[0], np.isfinite(rows).all(1), [0]]).astype(int)
    starts, ends = np.flatnonzero(np.diff(whole) == 1), np.flatnonzero(np.diff(whole) == -1)
    best = (ends - starts).argmax()
    return rows[starts[best] : ends[best]]


def inside(values: list[float], value: float, measure: str) -> tuple[float, float, bool]:
    """Return the 2.5th and 97.5th percentiles of a measure over windows, and whether a value lies between
    them.

    Lags are angles, taken within half a period of the windows' circular mean.
    """
    x = np.array(values)
    if measure == "lag":
        mean = np.angle(np.exp(2j * np.pi * x).mean()) / (2 * np.pi)
        x, value = (mean + (v - mean + 0.5) % 1 - 0.5 for v in (x, np.float64(value)))
    low, high = np.percentile(x, [2.5, 97.5])
    return float(low), float(high), bool(low <= value <= high)


def compare(cases: list[dict[str, Any]]) -> dict[tuple[str, str, str], dict[str, Any]]:
    """Return, for each world, each of its pairs and each measured pair, the measured values, the windows'
    values, and which measured values lie inside their range."""
    from studies.common.goats import numbers
    from studies.common.signature import signature, windows

    out = {}
    for world, pairs in PAIRS.items():
        runs = [
            {k: numbers(v) for k, v in e["result"]["numbers"].items()}
            for e in cases
            if e["case"]["arm"] == world
        ]
        for pair in pairs if runs else ():
            for name in SERIES:
                real, samples = signature(*measured(name)), len(measured(name)[0])
                found = [
                    w.as_dict()
                    for run in runs
                    for w in windows(*(run[of][len(run[of]) // 10 :] for of in pair), samples, real.period)
                ]
                if found:
                    out[world, "→".join(pair), name] = {
                        "real": real.as_dict(),
                        "windows": len(found),
                        **{m: inside([w[m] for w in found], real.as_dict()[m], m) for m in MEASURES},
                    }
    return out


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Test the registered hypotheses; return the verdicts and a table of all pairs."""
    compared = compare(cases)
    lynx, isle, gause = (
        compared.get(("predator-prey", "deer→wolf", name), {})
        for name in ("lynx-hare", "isle-royale", "gause")
    )

    def said(of: dict[str, Any], *names: str) -> str:
        return "; ".join(f"{of['real'][m]:.2f} in {of[m][0]:.2f} … {of[m][1]:.2f}" for m in names)

    def unlike(of: dict[str, Any]) -> int:
        return sum(not of[m][2] for m in MEASURES)

    lines = []
    if lynx and isle and gause:
        lines = [
            REGISTERED.verdict("lynx-lag", said(lynx, "lag"), lynx["lag"][2]),
            REGISTERED.verdict("lynx-regularity", said(lynx, "regularity"), lynx["regularity"][2]),
            REGISTERED.verdict(
                "lynx-swing", said(lynx, *MEASURES[2:]), all(lynx[m][2] for m in MEASURES[2:])
            ),
            REGISTERED.verdict("isle-royale", unlike(isle), unlike(isle) >= 1),
            REGISTERED.verdict("gause", unlike(gause), unlike(gause) >= 1),
        ]
    lines.append(
        verdict(
            "runs in which all species survived to the end",
            sum(e["result"]["lived"] >= CONFIG["ticks"] for e in cases),
            "reported",
            True,
        )
    )
    head = [
        "world",
        "pair",
        "measured series",
        "measured period [samples]",
        "windows",
        *(f"{m}: measured, windows" for m in MEASURES),
        "similar measures",
    ]
    rows = [
        [
            *key,
            of["real"]["period"],
            of["windows"],
            *(said(of, m) for m in MEASURES),
            f"{4 - unlike(of)} of 4",
        ]
        for key, of in compared.items()
    ]
    return {"verdicts": lines, "table": {"head": head, "rows": rows}, "notes": NOTES}


NOTES = (
    "Lags are shares of a period, from prey to predator; regularity is the share of the variance "
    "that one wave explains; swings are standard deviations of log10. Sources of the series: "
    "studies/data/SOURCES.md. The long series of lynx (1821 to 1934) has no series of prey and is drawn only."
)
WORLD_SEEDS: dict[str, list[int]] = REGISTERED.content["seeds"]["world"]
CONFIG = {"ticks": REGISTERED.content["ticks"], "block": BLOCK}
STUDY = Study(
    name="real_series",
    claim=REGISTERED.content["claim"],
    config=CONFIG,
    registered=REGISTERED,
    cases=[{"arm": world, "seed": seed} for world, seeds in WORLD_SEEDS.items() for seed in seeds],
    run=run,
    summarise=summarise,
    short_config={"ticks": 1500},
    short_cases=[{"arm": "predator-prey", "seed": 9101}],
)

if __name__ == "__main__":
    STUDY.main()
