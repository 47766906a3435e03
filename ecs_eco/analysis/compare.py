"""Comparison of the arms of an experiment: persistence, survival times, numbers and cycles. Seeds are the
replicates, training seeds and world seeds where policies of several were run (`seed_grid.py`)."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import chdtrc

from ecs_eco.analysis import compare_genes, measures
from ecs_eco.analysis.cycles import (
    CycleStatistics,
    cross_seed_surrogates,
    cycle_statistics,
    median_lag_interval,
)
from ecs_eco.analysis.extinction import shared
from ecs_eco.analysis.runs import Series, load_series
from ecs_eco.analysis.seed_grid import Grid, crossed, mean_interval, mean_of_seeds
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
    """Compare arms (name → run folders, series tables or `Series`,
    one a seed) with the first arm as the reference.

    `training` gives the training seed of each run of an arm with several: its runs, whose manifests have the
    world seeds, are then a crossed design. `policies` describes each arm's policies in words. Returns the
    content of compare.json; with `out`, writes compare.json, compare.html and figures/ there.
    """
    loaded, names = _load(arms, species)
    curves = {
        s: {arm: extinction_curve(runs, s) for arm, runs in loaded.items() if _there(runs, s)} for s in names
    }
    cycles = {
        arm: [cycle_statistics(run, n_boot=n_boot, seed=seed) for run in runs] for arm, runs in loaded.items()
    }
    reference = next(iter(loaded))
    grids = {arm: _grid_of(loaded[arm], seeds) for arm, seeds in (training or {}).items()}
    result: dict[str, Any] = {
        "format": 1,
        "reference": reference,
        "species": list(names),
        "opening": {arm: shared(runs) for arm, runs in loaded.items()},
        "arms": {
            arm: _arm(runs, {s: curves[s][arm] for s in names if arm in curves[s]}, cycles[arm], seed)
            for arm, runs in loaded.items()
        },
        "effects": {
            arm: _effects(loaded[reference], runs, names, seed)
            for arm, runs in loaded.items()
            if arm != reference
        },
    }
    if found := measures.of_arms(loaded, grids):
        result["measured"] = {"arms": found, "effects": measures.effects(loaded, grids, seed)}
    for arm, runs in loaded.items():
        rows = grids[arm].runs if arm in grids else [runs]
        for s in names:
            result["arms"][arm]["per_species"][s] |= _depths(rows, s)
    _add_crossed(result, loaded, grids, cycles, n_boot, seed)
    for arm, words in (policies or {}).items():
        result["arms"][arm]["policies"] = words
    genes = _add_genes(result, arms, _numbered(loaded, grids), seed)
    result = clean(result)
    if out is not None:
        from ecs_eco.analysis.compare_page import write

        write(Path(out), result, loaded, curves, grids, genes)
    return result


def _add_genes(
    result: dict[str, Any],
    arms: Mapping[str, Sequence[Any]],
    rows: Mapping[str, Sequence[Sequence[int]]],
    seed: int,
) -> list[compare_genes.Gene]:
    """Add what became of genes, where runs recorded genomes; `rows` are the runs of each arm, by number."""
    genes = compare_genes.genes_of(arms)
    if genes:
        result["genes"] = compare_genes.summary(genes, rows, result["reference"], seed)
    return genes


def _numbered(
    loaded: Mapping[str, Sequence[Series]], grids: Mapping[str, Grid]
) -> dict[str, list[list[int]]]:
    """Return the number of each run of an arm, in rows of training seeds."""
    number = {id(run): k for runs in loaded.values() for k, run in enumerate(runs)}
    return {
        arm: [[number[id(run)] for run in row] for row in (grids[arm].runs if arm in grids else [runs])]
        for arm, runs in loaded.items()
    }


def _add_crossed(
    result: dict[str, Any], loaded: Any, grids: Any, cycles: Any, n_boot: int, seed: int
) -> None:
    """Add what crossed designs say of their arms, and of the differences between these."""
    by_run = {id(run): c for arm in grids for run, c in zip(loaded[arm], cycles[arm], strict=True)}
    for arm, grid in grids.items():
        outcome = crossed(grid, by_run, n_boot=max(n_boot, 99), seed=seed)
        result["arms"][arm] |= {"crossed": outcome, "persistence": outcome["persistence"]}
    reference = result["reference"]
    for arm, effect in result["effects"].items():
        if arm in grids or reference in grids:
            effect |= _crossed_effects(loaded, grids, result, reference, arm)


def _load(
    arms: Mapping[str, Sequence[Any]], species: Sequence[str] | None
) -> tuple[dict[str, list[Series]], tuple[str, ...]]:
    """Return the runs of each arm, and their species; ValueError if there are no runs, or species differ."""
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
                    f"arm {arm!r} has a run of {', '.join(run.species)}, "
                    f"the first arm of {', '.join(names)}: compare runs of the same species"
                )
    return loaded, names


def _grid_of(runs: Sequence[Series], training: Sequence[int]) -> Grid:
    return Grid.of(runs, training, [int(run.manifest["seed"]) for run in runs])


def _crossed_effects(
    loaded: Mapping[str, Sequence[Series]],
    grids: Mapping[str, Grid],
    result: Mapping[str, Any],
    reference: str,
    arm: str,
) -> dict[str, Any]:
    """An arm minus the reference where both kinds of seeds are replicates.

    Shares: by the square-and-add rule from the intervals of both (Newcombe 1998; Zou and Donner 2008). Times
    and numbers: mean over the cells of the difference between runs of the same seeds; an arm without training
    seeds (random policies) has one row, which is compared with every training seed. No log-rank p: that test
    assumes independent runs.
    """
    one, two = result["arms"][arm]["persistence"], result["arms"][reference]["persistence"]
    effects: dict[str, Any] = {"persistence": difference_of_intervals(one, two)}
    first, second = (
        grids.get(name) or _grid_of(loaded[name], [0] * len(loaded[name])) for name in (arm, reference)
    )
    paired = first.worlds == second.worlds and (
        first.training == second.training or 1 in (len(first.training), len(second.training))
    )
    if not paired:
        return effects
    names = [s for s in result["species"] if _there(loaded[arm], s) and _there(loaded[reference], s)]
    values = {s: (partial(_lived, species=s), partial(_mean, species=s)) for s in names}
    gaps = {s: [mean_interval(first.table(f) - second.table(f)) for f in both] for s, both in values.items()}
    return effects | {
        "per_species": {
            s: {"lifetime": gaps[s][0], "log_rank_p": np.nan, "mean_number": gaps[s][1]} for s in names
        }
    }


def _there(runs: Sequence[Series], species: str) -> bool:
    """Whether a species was ever present; an arm without it has no lifetimes of it."""
    return any(run.present[run.index(species)] for run in runs)


def _lived(run: Series, species: str) -> float:
    return _lifetimes([run], species)[0][0]


def _mean(run: Series, species: str) -> float:
    return float(run.of(species).mean())


def extinction_curve(runs: Sequence[Series], species: str) -> SurvivalCurve:
    """Survival of a species over runs: time from the start to its extinction [ticks],
    censored at the end of the run."""
    return kaplan_meier(*_lifetimes(runs, species))


def _lifetimes(runs: Sequence[Series], species: str) -> tuple[list[float], list[bool]]:
    gone = [run.extinct[run.index(species)] for run in runs]
    lived = [
        float(run.length if np.isnan(t) else t - run.ticks[0]) for run, t in zip(runs, gone, strict=True)
    ]
    return lived, [not np.isnan(t) for t in gone]


def _arm(
    runs: Sequence[Series], curves: Mapping[str, SurvivalCurve], cycles: Sequence[CycleStatistics], seed: int
) -> dict[str, Any]:
    n, kept = len(runs), sum(run.persisted for run in runs)
    names = runs[0].species
    last = min(run.length for run in runs)
    usable = [c for c in cycles if c.enough]
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
                "median_extinction": curves[s].median if s in curves else np.nan,
                "mean_time": curves[s].mean(last) if s in curves else np.nan,
                "mean_number": float(np.mean([run.of(s).mean() for run in runs])),
                "long_enough": len(usable),
                "cycling": sum(s in c.cycling() for c in usable),
                "share_cycling": wilson(sum(s in c.cycling() for c in usable), len(usable)),
                "median_period": _median(
                    [peak.period for c in usable if (peak := c.peaks.get(s)) and s in c.cycling()]
                ),
                "pooled_p": _pooled([peak.p for c in usable if (peak := c.peaks.get(s))]),
                "cycling_ar1": sum((c.p_ar1.get(s) or 1.0) <= 0.05 for c in usable),
            }
            for i, s in enumerate(names)
        },
        "lags": {
            pair: median_lag_interval([c.lags[pair].share for c in usable if c.cycling() and pair in c.lags])
            for pair in pairs
        },
        "coupling": _coupling(runs, cycles, seed),
        "runs": [
            {"seed": run.manifest.get("seed"), "persisted": run.persisted, **c.as_dict()}
            for run, c in zip(runs, cycles, strict=True)
        ],
    }


def _depths(table: Sequence[Sequence[Series]], species: str) -> dict[str, Any]:
    """How mean depth follows the day over runs, rows of training seeds; empty where the species does not."""
    from ecs_eco.analysis.depth import depth_cycle, swimmers

    if species not in swimmers(table[0][0]):
        return {}
    cycles = [[depth_cycle(run, species) for run in row] for row in table]
    n = sum(c is not None for row in cycles for c in row)
    if not n:
        return {}
    of = {
        "amplitude": lambda c: c.share,
        "along_day": lambda c: c.share * float(np.cos(c.fit.acrophase)),
        "r": lambda c: c.r,
    }
    by_word = {
        word: np.array([[np.nan if c is None else value(c) for c in row] for row in cycles])
        for word, value in of.items()
    }
    return {"depth": {"n": n, **{word: mean_of_seeds(values) for word, values in by_word.items()}}}


def _pooled(p: Sequence[float]) -> float:
    """Fisher's combined p (Fisher 1925) over seeds: a cycle too weak for one run may be plain over ten."""
    return float(chdtrc(2 * len(p), -2 * np.log(p).sum())) if p else np.nan


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
            surrogates = cross_seed_surrogates([run for run, _ in kept], a, b, period, seed=seed)
        except ValueError:
            continue
        out[f"{a}→{b}"] = {
            "n": surrogates.n,
            "period": period,
            "coherency": surrogates.coherency,
            "share": surrogates.share,
            "p": surrogates.p,
        }
    return out


def _effects(
    reference: Sequence[Series], runs: Sequence[Series], names: Sequence[str], seed: int
) -> dict[str, Any]:
    """This arm minus the reference."""
    out: dict[str, Any] = {
        "persistence": difference_of_shares(
            sum(r.persisted for r in runs), len(runs), sum(r.persisted for r in reference), len(reference)
        ),
        "per_species": {},
    }
    for s in (s for s in names if _there(runs, s) and _there(reference, s)):
        a, b = _lifetimes(runs, s), _lifetimes(reference, s)
        out["per_species"][s] = {
            "lifetime": bootstrap_difference(a[0], b[0], seed=seed),
            "log_rank_p": log_rank(a, b)[1],
            "mean_number": bootstrap_difference(
                [r.of(s).mean() for r in runs], [r.of(s).mean() for r in reference], seed=seed
            ),
        }
    return out


def clean(x: Any) -> Any:
    """Return it with JSON types: intervals as [value, low, high], NaN and infinity as null."""
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
