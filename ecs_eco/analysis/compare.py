"""Arms of an experiment side by side: who persists, for how long, how many, and do they cycle?

An arm is a name and one run a seed. Seeds are the replicates; a run in which a species dies out is a result.
Where policies of several training seeds were run on the same world seeds, both are replicates (`analysis/crossed.py`).
Takes what runs left; it runs no world.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import partial
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

from ecs_eco.analysis import crossed_figures, figures
from ecs_eco.analysis.crossed import EFFECTS, Grid, crossed, mean_interval
from ecs_eco.analysis.cycles import CycleStatistics, cross_seed_surrogates, cycle_statistics, median_lag_interval
from ecs_eco.analysis.extinction import shared
from ecs_eco.analysis.page import number, page, picture, table, write_text
from ecs_eco.analysis.runs import Series, load_series
from ecs_eco.analysis.survival import (
    SurvivalCurve,
    bootstrap_difference,
    difference_of_intervals,
    difference_of_shares,
    kaplan_meier,
    log_rank,
    wilson,
)


def compare(
    arms: Mapping[str, Sequence[Any]],
    out: Path | str | None = None,
    *,
    species: Sequence[str] | None = None,
    n_boot: int = 499,
    seed: int = 0,
    training: Mapping[str, Sequence[int]] | None = None,
    policies: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Compare arms (name → run folders, series tables or `Series`, one a seed) with the first arm as the reference.

    `training` gives the training seed of each run of an arm whose policies were trained from several: its runs, which carry
    their world seeds in their manifests, are then a crossed design. `policies` says in words what an arm runs with.
    Returns what compare.json holds; with `out`, writes compare.json, compare.html and figures/ there.
    """
    if not arms:
        raise ValueError("nothing to compare: give at least one arm, name → runs")
    loaded = {arm: [load_series(run, species) for run in runs] for arm, runs in arms.items()}
    for arm, runs in loaded.items():
        if not runs:
            raise ValueError(f"arm {arm!r} has no runs: give at least one, better ten")
    names = next(iter(loaded.values()))[0].species
    for arm, runs in loaded.items():
        for run in runs:
            if run.species != names:
                raise ValueError(
                    f"arm {arm!r} has a run of {', '.join(run.species)}, the first arm of {', '.join(names)}: "
                    "compare runs of the same species"
                )
    curves = {s: {arm: extinction_curve(runs, s) for arm, runs in loaded.items()} for s in names}
    cycles = {arm: [cycle_statistics(run, n_boot=n_boot, seed=seed) for run in runs] for arm, runs in loaded.items()}
    reference = next(iter(loaded))
    grids = {arm: _grid_of(loaded[arm], seeds) for arm, seeds in (training or {}).items()}
    by_run = {id(run): c for arm in grids for run, c in zip(loaded[arm], cycles[arm], strict=True)}
    result: dict[str, Any] = {
        "format": 1,
        "reference": reference,
        "species": list(names),
        "opening": {arm: shared(runs) for arm, runs in loaded.items()},
        "arms": {
            arm: _arm(runs, {s: curves[s][arm] for s in names}, cycles[arm], seed) for arm, runs in loaded.items()
        },
        "effects": {
            arm: _effects(loaded[reference], runs, names, seed) for arm, runs in loaded.items() if arm != reference
        },
    }
    for arm, grid in grids.items():
        found = crossed(grid, by_run, n_boot=max(n_boot, 99), seed=seed)
        result["arms"][arm] |= {"crossed": found, "persistence": found["persistence"]}
    for arm, effect in result["effects"].items():
        if arm in grids or reference in grids:
            effect |= _crossed_effects(loaded, grids, result, reference, arm)
    for arm, words in (policies or {}).items():
        result["arms"][arm]["policies"] = words
    result = clean(result)
    if out is not None:
        _write(Path(out), result, loaded, curves, grids)
    return result


def _grid_of(runs: Sequence[Series], training: Sequence[int]) -> Grid:
    return Grid.of(runs, training, [int(run.manifest["seed"]) for run in runs])


def _crossed_effects(
    loaded: Mapping[str, Sequence[Series]], grids: Mapping[str, Grid], result: Mapping[str, Any], reference: str, arm: str
) -> dict[str, Any]:
    """An arm minus the reference where both kinds of seeds are replicates.

    Shares: by the square-and-add rule from the intervals of both (Newcombe 1998; Zou and Donner 2008). Times and numbers: mean
    over the cells of the difference between runs of the same seeds; an arm without training seeds (random policies) has one
    row, which stands against every training seed. No log-rank p: it takes runs for independent.
    """
    one, two = result["arms"][arm]["persistence"], result["arms"][reference]["persistence"]
    found: dict[str, Any] = {"persistence": difference_of_intervals(one, two)}
    first, second = (grids.get(name) or _grid_of(loaded[name], [0] * len(loaded[name])) for name in (arm, reference))
    paired = first.worlds == second.worlds and (first.training == second.training or 1 in (len(first.training), len(second.training)))
    if not paired:
        return found
    names = result["species"]
    values = {s: (partial(_lived, species=s), partial(_mean, species=s)) for s in names}
    gaps = {s: [mean_interval(first.table(f) - second.table(f)) for f in both] for s, both in values.items()}
    return found | {"per_species": {s: {"lifetime": gaps[s][0], "log_rank_p": np.nan, "mean_number": gaps[s][1]} for s in names}}


def _lived(run: Series, species: str) -> float:
    return _lifetimes([run], species)[0][0]


def _mean(run: Series, species: str) -> float:
    return float(run.of(species).mean())


def extinction_curve(runs: Sequence[Series], species: str) -> SurvivalCurve:
    """Survival of a species over runs: time from the start to its extinction [ticks], censored at the end of the run."""
    return kaplan_meier(*_lifetimes(runs, species))


def _lifetimes(runs: Sequence[Series], species: str) -> tuple[list[float], list[bool]]:
    gone = [run.extinct[run.index(species)] for run in runs]
    lived = [float((run.ticks[-1] if np.isnan(t) else t) - run.ticks[0]) for run, t in zip(runs, gone, strict=True)]
    return lived, [not np.isnan(t) for t in gone]


def _arm(
    runs: Sequence[Series], curves: Mapping[str, SurvivalCurve], cycles: Sequence[CycleStatistics], seed: int
) -> dict[str, Any]:
    n, kept = len(runs), sum(run.persisted for run in runs)
    names = runs[0].species
    last = min(int(run.ticks[-1] - run.ticks[0]) for run in runs)
    found = [c for c in cycles if c.enough]
    pairs = [f"{a}→{b}" for i, a in enumerate(names) for b in names[i + 1 :]]
    return {
        "n": n,
        "seeds": [run.manifest.get("seed") for run in runs],
        "ticks": last,
        "persisted": kept,
        "persistence": wilson(kept, n),
        "per_species": {
            s: {
                "extinctions": sum(bool(run.present[i] and not np.isnan(run.extinct[i])) for run in runs),
                "median_extinction": curves[s].median,
                "mean_time": curves[s].mean(last),
                "mean_number": float(np.mean([run.of(s).mean() for run in runs])),
                "long_enough": len(found),
                "cycling": sum(s in c.cycling() for c in found),
                "share_cycling": wilson(sum(s in c.cycling() for c in found), len(found)),
                "median_period": _median([peak.period for c in found if (peak := c.peaks.get(s)) and s in c.cycling()]),
                "pooled_p": _pooled([peak.p for c in found if (peak := c.peaks.get(s))]),
                "cycling_ar1": sum((c.p_ar1.get(s) or 1.0) <= 0.05 for c in found),
                **_depths(runs, s),
            }
            for i, s in enumerate(names)
        },
        "lags": {
            pair: median_lag_interval([c.lags[pair].share for c in found if c.cycling() and pair in c.lags])
            for pair in pairs
        },
        "coupling": _coupling(runs, cycles, seed),
        "runs": [
            {"seed": run.manifest.get("seed"), "persisted": run.persisted, **c.as_dict()}
            for run, c in zip(runs, cycles, strict=True)
        ],
    }


def _depths(runs: Sequence[Series], species: str) -> dict[str, Any]:
    """Over runs, how mean depth follows the day; empty where there is no sun, no depth, or nobody lived two days."""
    from ecs_eco.analysis.sea import depth_cycle, swimmers

    if species not in swimmers(runs[0]):
        return {}
    found = [c for run in runs if (c := depth_cycle(run, species)) is not None]
    if not found:
        return {}
    shares = {"amplitude": [c.share for c in found], "along_day": [c.share * float(np.cos(c.fit.acrophase)) for c in found]}
    r = [c.r for c in found if np.isfinite(c.r)]
    return {"depth": {"n": len(found), **{k: float(np.mean(v)) for k, v in shares.items()}, "r": float(np.mean(r)) if r else None}}


def _pooled(p: Sequence[float]) -> float:
    """Fisher's combined p (Fisher 1925) over seeds: a cycle too weak for one run may be plain over ten."""
    return float(chi2.sf(-2 * np.log(p).sum(), 2 * len(p))) if p else np.nan


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if len(values) else np.nan


def _coupling(runs: Sequence[Series], cycles: Sequence[CycleStatistics], seed: int) -> dict[str, Any]:
    """Cross-seed surrogates of each adjacent pair, over the runs in which everybody persisted."""
    kept = [(run, c) for run, c in zip(runs, cycles, strict=True) if run.persisted and c.period]
    if len(kept) < 4:
        return {}
    period = float(np.median([c.period for _, c in kept]))
    out = {}
    for a, b in zip(runs[0].species, runs[0].species[1:], strict=False):
        try:
            found = cross_seed_surrogates([run for run, _ in kept], a, b, period, seed=seed)
        except ValueError:
            continue
        out[f"{a}→{b}"] = {
            "n": found.n,
            "period": period,
            "coherency": found.coherency,
            "share": found.share,
            "p": found.p,
        }
    return out


def _effects(reference: Sequence[Series], runs: Sequence[Series], names: Sequence[str], seed: int) -> dict[str, Any]:
    """This arm minus the reference."""
    out: dict[str, Any] = {
        "persistence": difference_of_shares(
            sum(r.persisted for r in runs), len(runs), sum(r.persisted for r in reference), len(reference)
        ),
        "per_species": {},
    }
    for s in names:
        a, b = _lifetimes(runs, s), _lifetimes(reference, s)
        out["per_species"][s] = {
            "lifetime": bootstrap_difference(a[0], b[0], seed=seed),
            "log_rank_p": log_rank([a, b])[1],
            "mean_number": bootstrap_difference(
                [r.of(s).mean() for r in runs], [r.of(s).mean() for r in reference], seed=seed
            ),
        }
    return out


def clean(x: Any) -> Any:
    """The same in types of JSON: intervals as [value, low, high], NaN and infinity as null."""
    if isinstance(x, Mapping):
        return {str(k): clean(v) for k, v in x.items()}
    if isinstance(x, list | tuple | np.ndarray):
        return [clean(v) for v in x]
    if isinstance(x, np.bool_ | bool):
        return bool(x)
    if isinstance(x, int | np.integer):
        return int(x)
    if isinstance(x, float | np.floating):
        return float(x) if np.isfinite(x) else None
    return x


def _interval(x: Sequence[float]) -> str:
    return f"{number(x[0])} ({number(x[1])} … {number(x[2])})"


def _write(
    out: Path,
    result: dict[str, Any],
    loaded: Mapping[str, Sequence[Series]],
    curves: Mapping[str, Mapping[str, SurvivalCurve]],
    grids: Mapping[str, Grid],
) -> None:
    write_text(out / "compare.json", json.dumps(result, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    until = max(arm["ticks"] for arm in result["arms"].values())
    shown = [s for s in result["species"] if any(c.died.any() for c in curves[s].values())]
    pictures = [
        picture(
            figures.save(figures.survival(curves[s], until, f"{s} persists"), out / "figures" / f"survival_{s}.png"),
            _CURVE.format(s),
        )
        for s in shown
    ]
    pictures.append(picture(figures.save(figures.arms(loaded), out / "figures" / "numbers.png"), _MEANS))
    drawn = {arm: _draw_grid(out / "figures", arm, grid) for arm, grid in grids.items()}
    write_text(out / "compare.html", page("Comparison of " + ", ".join(result["arms"]), *_blocks(result, pictures, drawn)))


def _draw_grid(folder: Path, arm: str, grid: Grid) -> list[str]:
    """Survival by training seed and the map of first extinctions of one arm, as HTML."""
    curve = figures.save(crossed_figures.persistence(grid, f"{arm}: all species persist"), folder / f"persistence_{arm}.png")
    cells = figures.save(crossed_figures.lifetimes(grid, f"{arm}: first extinction"), folder / f"first_extinction_{arm}.png")
    return [picture(curve, _BY_SEED), picture(cells, _CELLS)]


_CURVE = "Share of runs in which {} lives (Kaplan–Meier, 95 % bands)."
_BY_SEED = "Share of runs in which all species live: all runs thick, with a band over both kinds of seeds (95 %); each training seed thin."
_CELLS = "The tick at which the first species died out, and which it was, by training seed and world seed."
_MEANS = "Numbers over time: every run thin, the median over runs thick."


def _opening(result: dict[str, Any]) -> str:
    """What the page opens with: in how many runs of each arm all species persisted, and who died out of what."""
    lines = "".join(f"<p>{escape(arm)}: {escape(text)}</p>" for arm, text in result["opening"].items())
    lost = any(a["persisted"] < a["n"] for a in result["arms"].values())
    return f"<div class='verdict{' lost' if lost else ''}'>{lines}</div>"


def _crossed_blocks(result: dict[str, Any], drawn: Mapping[str, Sequence[str]]) -> list[str]:
    """The crossed design of the arms that have one: by training seed, and whence the variance comes."""
    found = {arm: a["crossed"] for arm, a in result["arms"].items() if "crossed" in a}
    if not found:
        return []
    blocks = ["<h2>Training seed and world seed</h2>"]
    for arm, c in found.items():
        worlds = len(c["world_seeds"])
        each = ", ".join(f"{seed}: {kept}" for seed, kept in c["persisted_by_training_seed"].items())
        blocks.append(
            f"<p>{escape(arm)}: {len(c['training_seeds'])} training seeds × {worlds} world seeds. Runs of {worlds} in which all "
            f"persist, by training seed: {each}. The {len(c['training_seeds']) * worlds} runs say as much about that share as "
            f"{number(c['effective_runs'])} independent ones would.</p>"
        )
        blocks += drawn[arm]
    rows = [
        [arm, outcome, x["n"], *(_share(x["share"][effect]) for effect in EFFECTS)]
        for arm, c in found.items()
        for outcome, x in c["variance_shares"].items()
    ]
    if rows:
        blocks.append(_SHARES)
        blocks.append(table(["arm", "outcome", "runs", *EFFECTS], rows))
    return blocks


def _share(x: Sequence[float]) -> str:
    return "–" if x[0] is None else f"{x[0]:.2f} ({x[1]:.2f} … {x[2]:.2f})"


_SHARES = (
    "<p>Whence the variance comes: shares of training seed, of world seed and of the rest, which is chance and the interaction of both. "
    "“Persisted” counts as 0 and 1, on the linear scale; a time that the end of the run cut off counts as the whole run; a period is told "
    "where a run cycles. A dash: nothing varies. Intervals by a two-way bootstrap.</p>"
)


def _blocks(result: dict[str, Any], pictures: Sequence[str], drawn: Mapping[str, Sequence[str]]) -> list[str]:
    arms, names = result["arms"], result["species"]
    who = [
        [arm, a["n"], f"{a['ticks']:,}", a["persisted"], _interval(a["persistence"])]
        + [
            f"{a['per_species'][s]['extinctions']} of {a['n']}, median {number(a['per_species'][s]['median_extinction'])}"
            for s in names
        ]
        for arm, a in arms.items()
    ]
    cycling = [
        [
            arm,
            s,
            f"{x['cycling']} of {x['long_enough']}",
            number(x["pooled_p"], 2),
            f"{x['cycling_ar1']} of {x['long_enough']}",
            number(x["median_period"]),
            number(x["mean_number"]),
        ]
        for arm, a in arms.items()
        for s, x in a["per_species"].items()
    ]
    lag = [
        [
            arm,
            pair,
            x["n"],
            f"{number(x['median'])} ({number(x['low'])} … {number(x['high'])})",
            number(a["coupling"].get(pair, {}).get("p")),
        ]
        for arm, a in arms.items()
        for pair, x in a["lags"].items()
        if x["n"]
    ]
    gaps = [
        [arm, s, _interval(x["lifetime"]), number(x["log_rank_p"]), _interval(x["mean_number"])]
        for arm, e in result["effects"].items()
        for s, x in e["per_species"].items()
    ]
    blocks = [
        f"<h1>Comparison of {len(arms)} arms</h1>",
        _opening(result),
        "<p class='under'>Seeds are the replicates. Intervals are 95 %.</p>",
        *(f"<p class='under'>{escape(arm)} runs with {escape(a['policies'])}.</p>" for arm, a in arms.items() if "policies" in a),
        "<h2>Who persists</h2>",
        table(["arm", "runs", "ticks", "all persist", "share", *(f"{s} extinct" for s in names)], who),
        *pictures[:-1],
        *_crossed_blocks(result, drawn),
    ]

    if gaps:
        share = [[arm, _interval(e["persistence"])] for arm, e in result["effects"].items()]
        blocks += [
            f"<h2>Against {result['reference']}</h2>",
            table(["arm", "share that persists, difference (Newcombe)"], share),
        ]
        blocks.append(
            table(["arm", "species", "ticks lived, difference", "log-rank p", "mean number, difference"], gaps)
        )
    blocks += ["<h2>Numbers</h2>", pictures[-1], "<h2>Cycles</h2>"]
    blocks.append(
        "<p>Runs whose spectrum has a peak beyond red noise that only relaxes (p ≤ .05 in each run; by luck 1 in 20), "
        "and beyond AR(1), which calls smooth series periodic.</p>"
    )
    blocks.append(
        table(
            ["arm", "species", "cycling", "p over all seeds", "beyond AR(1)", "median period [ticks]", "mean number"],
            cycling,
        )
    )
    if lag:
        blocks += [
            "<p>Lags as share of the period, over cycling runs; p tests the pair against pairs from different runs.</p>"
        ]
        blocks.append(table(["arm", "pair", "runs", "median lag", "coupling p"], lag))
    return blocks
