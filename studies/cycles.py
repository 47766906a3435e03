"""Do grass, deer and wolves cycle, each following the species it eats, when policies are learned and then
frozen?

The study runs the bundled policies (training seed 1) on fresh world seeds; persistence.py covers other
training seeds, and learning_in_life.py covers learning during life. Peaks are tested against red noise:
AR(1), as planned, and a stricter model that relaxes at two rates.
"""

from typing import Any

import numpy as np

from studies.common.predator_prey import first_extinction, frozen, identity, live, numbers, packed, unpacked
from studies.common.study import Study, verdict

FRESH = tuple(range(1001, 1011))  # world seeds that were not used for any choice
BLOCK = 40  # [ticks] averaged into each stored mean
LAGS = {"deer→wolf": (0.20, 0.35), "grass→deer": (0.28, 0.50)}


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one world; return the species that went extinct and when, and peaks, periods, lags and population
    sizes."""
    from ecs_eco.analysis.cycles import cycle_statistics

    lived = live(frozen(), case["seed"], "trained", config["ticks"], learn=False)
    n = numbers(lived)
    when, who = first_extinction(n)
    return {
        "lived": when,
        "extinct": who,
        "mean": n.mean(0).round(),
        "least": n.min(0),
        "most": n.max(0),
        "cycles": cycle_statistics(lived.series(), period_of=config["period of"]).as_dict(),
        "numbers": packed(n, BLOCK),
    }


def periods(result: dict[str, Any]) -> float:
    """Return the number of periods in the run, excluding its start."""
    c = result["cycles"]
    return c["ticks"] / c["period"] if c["period"] else 0.0


def count(results: list[dict[str, Any]], species: str, null: str) -> int:
    """Return the number of runs with a peak that exceeds a null model at p < 0.05."""

    def p(r: dict[str, Any]) -> float | None:
        c = r["cycles"]
        return c["p_ar1"].get(species) if null == "ar1" else (c["peaks"].get(species) or {}).get("p")

    return sum(v is not None and v < 0.05 for v in map(p, results))


def coupling(results: list[dict[str, Any]], pair: str) -> Any:
    """Return cross-seed surrogates for a pair over the runs in which all species persist; None for fewer than
    four runs."""
    from ecs_eco.analysis.cycles import cross_seed_surrogates

    kept = [r for r in results if r["extinct"] is None and r["cycles"]["period"]]
    if len(kept) < 4:
        return None
    period = float(np.median([r["cycles"]["period"] for r in kept])) / BLOCK
    return cross_seed_surrogates([unpacked(r["numbers"], BLOCK) for r in kept], *pair.split("→"), period)


def row(name: str, results: list[dict[str, Any]]) -> list[Any]:
    """Return one row of the table."""
    from ecs_eco.analysis.cycles import median_lag_interval

    lags = {
        pair: median_lag_interval(
            [r["cycles"]["lags"][pair]["share"] for r in results if pair in r["cycles"]["lags"]]
        )
        for pair in LAGS
    }
    periods = [r["cycles"]["period"] for r in results if r["cycles"]["period"]]
    return [
        name,
        len(results),
        sum(r["extinct"] is None for r in results),
        float(np.median(periods)) if periods else None,
        *(count(results, s, null) for null in ("ar1", "relaxation") for s in ("deer", "wolf")),
        *([v["median"], v["low"], v["high"]] if v["n"] else None for v in lags.values()),
    ]


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Test the bundled policies."""
    from ecs_eco.analysis.cycles import median_lag_interval

    main = [entry["result"] for entry in cases]
    n, kept = len(main), sum(r["extinct"] is None for r in main)
    least = min(periods(r) for r in main)
    out = [
        verdict(
            "bundled policies, fresh world seeds: runs in which grass, deer and wolves persist",
            f"{kept} of {n}",
            "all",
            kept == n,
        ),
        verdict("fewest periods in a run", least, "at least 10", least >= 10),
    ]
    for species, named in (("deer", "deer"), ("wolf", "wolves")):
        peaks = count(main, species, "ar1")
        out.append(
            verdict(
                f"runs with a spectral peak of {named} beyond AR(1), p < 0.05",
                f"{peaks} of {n}",
                "at least 9 of 10",
                peaks >= 0.9 * n,
            )
        )
    for species, named in (("deer", "deer"), ("wolf", "wolves")):
        peaks = count(main, species, "relaxation")
        out.append(
            verdict(
                f"stricter test: runs with a spectral peak of {named} beyond red noise with two relaxation rates",
                f"{peaks} of {n}",
                "at least 9 of 10",
                peaks >= 0.9 * n,
            )
        )
    for pair, (low, high) in LAGS.items():
        lag = median_lag_interval(
            [r["cycles"]["lags"][pair]["share"] for r in main if pair in r["cycles"]["lags"]]
        )
        out.append(
            verdict(
                f"median lag {pair}, as a share of the period",
                [lag["median"], lag["low"], lag["high"]],
                f"{low} to {high}",
                low <= lag["median"] <= high,
            )
        )
        surrogate = coupling(main, pair)
        if surrogate is not None:
            out.append(
                verdict(
                    f"{pair} in the same run against pairs of different runs: "
                    f"coherency {surrogate.coherency:.2f}, p-value",
                    surrogate.p,
                    "< 0.05",
                    surrogate.p < 0.05,
                )
            )
    head = [
        "arm",
        "runs",
        "runs in which all persist",
        "median period [ticks]",
        "deer > AR(1)",
        "wolf > AR(1)",
        "deer, stricter test",
        "wolf, stricter test",
        *LAGS,
    ]
    return {"verdicts": out, "table": {"head": head, "rows": [row("bundled", main)]}}


STUDY = Study(
    name="cycles",
    claim="Grass, deer and wolves with learned policies cycle: deer follow grass, wolves follow deer.",
    config={
        "world": "predator-prey",
        "identity": identity(),
        "ticks": 20_000,
        "block": BLOCK,
        "period of": ["deer", "wolf"],
        "seeds": {
            "parameters chosen on": "policies of training seeds 1–4 on world seeds 100–103",
            "bundled": "training seed 1, not selected",
            "fresh": list(FRESH),
        },
    },
    cases=[{"seed": s} for s in FRESH],
    run=run,
    summarise=summarise,
    short_cases=[{"seed": FRESH[0]}],
    short_config={"ticks": 2500},
)

if __name__ == "__main__":
    STUDY.main()
