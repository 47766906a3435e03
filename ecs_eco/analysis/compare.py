"""Comparison of an experiment's arms: persistence, survival times, population sizes and cycles. Replicates are
world seeds and, if runs use policies from several training runs, training seeds (`seed_grid.py`)."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from html import escape
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import chdtrc

from ecs_eco.analysis import compare_genes, depth_figures, figures, measures, seed_grid
from ecs_eco.analysis.cycles import (
    CycleStatistics,
    cross_seed_surrogates,
    cycle_statistics,
    median_lag_interval,
)
from ecs_eco.analysis.depth import depth_cycle, swimmers
from ecs_eco.analysis.extinction import shared
from ecs_eco.analysis.page import drawn, interval, number, page, table, verdict, write_text
from ecs_eco.analysis.replicates import Effect, differing, seeds_section
from ecs_eco.analysis.runs import Series, load_series
from ecs_eco.analysis.seed_grid import EFFECTS, Grid, crossed, mean_interval, mean_of_seeds
from ecs_eco.analysis.survival import (
    Interval,
    SurvivalCurve,
    bootstrap_difference,
    difference_of_intervals,
    difference_of_shares,
    kaplan_meier,
    log_rank,
    wilson,
)
from ecs_eco.engine.errors import in_words


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
    """Compare recorded runs of several arms; the first arm is the reference.

    Parameters
    ----------
    arms : Mapping of str to sequence
        The runs of each arm, one per seed: folders, tables of series or `Series` objects.
    out : str or Path, optional
        Folder for compare.json, compare.html and figures/.
    species : sequence of str, optional
        Default: all.
    n_boot : int, default 499
        Number of red-noise simulations.
    seed : int, default 0
        Random seed for the simulations.
    training : Mapping of str to sequence of int, optional
        Training seed of each run, for arms in which training seeds are crossed with world seeds.
    policies : Mapping of str to str, optional
        Descriptions of each arm's policies, shown on the page.

    Returns
    -------
    dict
        Contents of compare.json.

    See Also
    --------
    ecs_eco.lab.compare : also runs the arms.

    Examples
    --------
    >>> from ecs_eco.analysis.compare import compare
    >>> one, other = {"hare": [9, 8, 7], "lynx": [2, 1, 0]}, {"hare": [9, 9, 8], "lynx": [2, 2, 1]}
    >>> compare({"alone": [one], "fed": [other]})["opening"]["fed"]
    'All species persisted in 1 of 1 run (100%).'
    """
    loaded, names = _load(arms, species)
    curves = {
        s: {arm: kaplan_meier(*_lifetimes(runs, s)) for arm, runs in loaded.items() if _there(runs, s)}
        for s in names
    }
    cycles = {
        arm: [cycle_statistics(run, n_boot=n_boot, seed=seed) for run in runs] for arm, runs in loaded.items()
    }
    reference = next(iter(loaded))
    grids = {arm: _grid_of(loaded[arm], seeds) for arm, seeds in (training or {}).items()}
    others = [arm for arm in loaded if arm != reference]
    of_arm = {arm: {s: curves[s][arm] for s in names if arm in curves[s]} for arm in loaded}
    result: dict[str, Any] = {
        "format": 1,
        "reference": reference,
        "species": list(names),
        "opening": {arm: shared(runs) for arm, runs in loaded.items()},
        "arms": {arm: _arm(runs, of_arm[arm], cycles[arm], seed) for arm, runs in loaded.items()},
        "effects": {arm: _effects(loaded[reference], loaded[arm], names, seed) for arm in others},
    }
    rows = {arm: grids[arm].runs if arm in grids else [runs] for arm, runs in loaded.items()}
    if found := measures.of_arms(rows):
        result["measured"] = {"arms": found, "effects": measures.effects(rows, grids, seed)}
    for arm, of in rows.items():
        for s in names:
            result["arms"][arm]["per_species"][s] |= _depths(of, s)
    by_run = {id(run): c for arm in grids for run, c in zip(loaded[arm], cycles[arm], strict=True)}
    for arm, grid in grids.items():
        outcome = crossed(grid, by_run, n_boot=max(n_boot, 99), seed=seed)
        result["arms"][arm] |= {"crossed": outcome, "persistence": outcome["persistence"]}
    for arm, effect in result["effects"].items():
        if arm in grids or reference in grids:
            effect |= _crossed_effects(loaded, grids, result, reference, arm)
    for arm, words in (policies or {}).items():
        result["arms"][arm]["policies"] = words
    if genes := compare_genes.genes_of(arms):
        number = {id(run): k for runs in loaded.values() for k, run in enumerate(runs)}
        numbers = {arm: [[number[id(run)] for run in row] for row in of] for arm, of in rows.items()}
        result["genes"] = compare_genes.summary(genes, numbers, reference, seed)
    result = clean(result)
    if out is not None:
        write(Path(out), result, loaded, curves, grids, genes)
    return result


def _load(
    arms: Mapping[str, Sequence[Any]], species: Sequence[str] | None
) -> tuple[dict[str, list[Series]], tuple[str, ...]]:
    """Return the runs of each arm, and their species; raise ValueError if runs are missing or species differ."""
    if not arms:
        raise ValueError("nothing to compare: pass at least one arm, name → runs")
    loaded = {arm: [load_series(run, species) for run in runs] for arm, runs in arms.items()}
    for arm, runs in loaded.items():
        if not runs:
            raise ValueError(f"arm {arm!r} has no runs: pass at least one, preferably ten")
    names = next(iter(loaded.values()))[0].species
    for arm, runs in loaded.items():
        for run in runs:
            if run.species != names:
                fault = f"arm {arm!r} has a run with {', '.join(run.species)}, but the first arm has "
                raise ValueError(f"{fault}{', '.join(names)}: compare runs of the same species")
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
    """Return the difference between an arm and the reference, with both kinds of seeds as replicates. For times and
    population sizes, the difference between runs with the same seeds is averaged over cells; an arm without
    training seeds (random policies) has one row, which is compared with every training seed. No log-rank p
    value is given, because that test assumes independent runs."""
    one, two = result["arms"][arm]["persistence"], result["arms"][reference]["persistence"]
    effects: dict[str, Any] = {"persistence": difference_of_intervals(one, two)}
    alone = {name: [0] * len(loaded[name]) for name in (arm, reference)}
    first, second = (grids.get(name) or _grid_of(loaded[name], seeds) for name, seeds in alone.items())
    same = first.training == second.training or 1 in (len(first.training), len(second.training))
    if first.worlds != second.worlds or not same:
        return effects
    names = [s for s in result["species"] if _there(loaded[arm], s) and _there(loaded[reference], s)]

    def gap(value: Callable[[Series, str], float], s: str) -> Interval:
        return mean_interval(first.table(lambda run: value(run, s)) - second.table(lambda run: value(run, s)))

    return effects | {
        "per_species": {
            s: {
                "lifetime": gap(lambda run, s: _lifetimes([run], s)[0][0], s),
                "log_rank_p": np.nan,
                "mean_number": gap(lambda run, s: run.of(s).mean(), s),
            }
            for s in names
        }
    }


def _there(runs: Sequence[Series], species: str) -> bool:
    """Return whether a species was present in any run of an arm; if not, the arm has no lifetimes."""
    return any(run.present[run.index(species)] for run in runs)


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
                **_pooled(usable, s),
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
    """Return the mean daily cycle of mean depth, if any, over runs with a row for each training seed."""
    swims = species in swimmers(table[0][0])
    cycles = [[depth_cycle(run, species) if swims else None for run in row] for row in table]
    n = sum(c is not None for row in cycles for c in row)
    if not n:
        return {}
    missing = (np.nan,) * 3
    values = [
        [missing if c is None else (c.share, c.share * float(np.cos(c.fit.acrophase)), c.r) for c in row]
        for row in cycles
    ]
    amplitude, along_day, r = (mean_of_seeds(of) for of in np.moveaxis(np.array(values), 2, 0))
    return {"depth": {"n": n, "amplitude": amplitude, "along_day": along_day, "r": r}}


def _pooled(cycles: Sequence[CycleStatistics], s: str) -> dict[str, float]:
    """Return the median period of the cycling runs, and the combined p value over all runs (Fisher 1925)."""
    p = [peak.p for c in cycles if (peak := c.peaks.get(s))]
    periods = [peak.period for c in cycles if (peak := c.peaks.get(s)) and s in c.cycling()]
    return {
        "median_period": float(np.median(periods)) if periods else np.nan,
        "pooled_p": float(chdtrc(2 * len(p), -2 * np.log(p).sum())) if p else np.nan,
    }


def _coupling(runs: Sequence[Series], cycles: Sequence[CycleStatistics], seed: int) -> dict[str, Any]:
    """Return the surrogate test for each pair of adjacent species, over the runs in which all species persisted."""
    kept = [(run, c) for run, c in zip(runs, cycles, strict=True) if run.persisted and c.period]
    if len(kept) < 4:
        return {}
    period = float(np.median([c.period for _, c in kept]))
    out, present = dict[str, Any](), [s for s in runs[0].species if _there(runs, s)]
    for a, b in zip(present, present[1:], strict=False):
        try:
            surrogates = cross_seed_surrogates([run for run, _ in kept], a, b, period, seed=seed)
        except ValueError:
            continue
        kept_of = {word: getattr(surrogates, word) for word in ("coherency", "share", "p")}
        out[f"{a}→{b}"] = {"n": surrogates.n, "period": period, **kept_of}
    return out


def _effects(
    reference: Sequence[Series], runs: Sequence[Series], names: Sequence[str], seed: int
) -> dict[str, Any]:
    """Return the differences between this arm and the reference."""
    kept = [(sum(r.persisted for r in arm), len(arm)) for arm in (runs, reference)]
    out: dict[str, Any] = {"persistence": difference_of_shares(*kept[0], *kept[1]), "per_species": {}}
    for s in (s for s in names if _there(runs, s) and _there(reference, s)):
        a, b = _lifetimes(runs, s), _lifetimes(reference, s)
        means = ([r.of(s).mean() for r in arm] for arm in (runs, reference))
        out["per_species"][s] = {
            "lifetime": bootstrap_difference(a[0], b[0], seed=seed),
            "log_rank_p": log_rank(a, b)[1],
            "mean_number": bootstrap_difference(*means, seed=seed),
        }
    return out


def clean(x: object) -> Any:
    """Convert a value to JSON types: intervals to [value, low, high], NaN and infinity to null."""
    if isinstance(x, np.ndarray | np.generic):
        return clean(x.tolist())
    if isinstance(x, Mapping):
        return {str(k): clean(v) for k, v in x.items()}
    if isinstance(x, list | tuple):
        return [clean(v) for v in x]
    return None if isinstance(x, float) and not np.isfinite(x) else x


def write(
    out: Path,
    result: dict[str, Any],
    loaded: Mapping[str, Sequence[Series]],
    curves: Mapping[str, Mapping[str, SurvivalCurve]],
    grids: Mapping[str, Grid],
    genes: Sequence[compare_genes.Gene] = (),
) -> None:
    """Write the result of `compare`; runs, survival curves, grids and genes are passed separately."""
    write_text(out / "compare.json", json.dumps(result, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    blocks = [
        *_head(result, loaded),
        *_who(out, result, curves),
        *_crossed(out, result, grids),
        *_against(result),
        *_seeds(loaded, grids),
        *_depth(out, result, loaded),
        "<h2>Numbers</h2>",
        drawn(figures.arms(loaded), out / "figures" / "numbers.svg", _MEANS),
        *_measured(out, result, loaded),
        *compare_genes.blocks(out, genes, result.get("genes", {}), result["reference"]),
        *_cycles(result),
    ]
    write_text(out / "compare.html", page("Comparison of " + ", ".join(result["arms"]), *blocks))


def _share(x: Sequence[float]) -> str:
    return "–" if x[0] is None else f"{x[0]:.2f} ({x[1]:.2f} to {x[2]:.2f})"


_CURVE = "Fraction of runs in which {} persists (Kaplan–Meier, 95% bands)."
_BY_SEED = (
    "Fraction of runs in which all species persist. Thick line: all runs, with a 95% band over both kinds "
    "of seeds. Thin lines: training seeds."
)
_CELLS = "Tick and species of the first extinction, by training seed and world seed."
_MEANS = "Numbers over time. Thin lines: runs. Thick line: their median."
_REPORTED = (
    "Values of the world's reporters over time. Thin lines: runs. Thick line: their median. The table shows "
    "the mean over time, averaged over runs, with 95% intervals."
)
_HOURS = (
    "Mean depth by hour of the day, excluding the first day. Thin lines: runs. Thick line: their mean. "
    "Gray: night."
)
_SHARES = (
    "<p>Sources of variance: the fractions due to the training seed, the world seed and the rest (chance "
    "and the interaction of both seeds). “Persisted” counts as 0 or 1 on a linear scale; a run without an "
    "extinction contributes its full length; a period is given only for runs that cycle. A dash means no variance. "
    "Intervals are from a two-way bootstrap.</p>"
)
_DEPTH = (
    "<p>A cosine with a period of one day is fitted to mean depth. The table shows its amplitude as a "
    "fraction of the water's depth; its component in phase with the sun, positive if a species is deepest at "
    "noon and negative if it is deepest at midnight; and the correlation of mean depth with light. Values "
    "are means over runs, with 95% intervals.</p>"
)
_LAGS = (
    "<p>Lags in cycling runs, as fractions of the period; p tests each pair against pairs from different "
    "runs.</p>"
)
_PEAKS = (
    "<p>Number of runs with a spectral peak above red noise that does not oscillate (p ≤ 0.05 in each run; "
    "by chance, 1 run in 20), and above AR(1), a null model that is too lenient for smooth series.</p>"
)


def _head(result: dict[str, Any], loaded: Mapping[str, Sequence[Series]]) -> list[str]:
    """Return the top of the page: the world, persistence in each arm, and clear differences in mean numbers."""
    arms, told = (
        result["arms"],
        [
            *result["opening"].items(),
            *((arm, differing(of, result["reference"])) for arm, of in result["effects"].items()),
        ],
    )
    lines = [f"{in_words(a for a, t in told if t == x)}: {x}" for x in dict.fromkeys(t for _, t in told)]
    of = {str(run.manifest.get("world", "")) for run in chain(*loaded.values())}
    known = [f"{arm} runs with {a['policies']}." for arm, a in arms.items() if "policies" in a]
    return [
        f"<h1>{escape(': '.join([*of, '']) if len(of) == 1 and all(of) else '')}{len(arms)} arms compared</h1>",
        verdict(lines, any(a["persisted"] < a["n"] for a in arms.values())),
        "<p class='under'>The replicates are seeds. All intervals are 95% intervals. "
        f"{escape(' '.join(known))}</p>",
    ]


def _who(
    out: Path, result: dict[str, Any], curves: Mapping[str, Mapping[str, SurvivalCurve]]
) -> Iterator[str]:
    """Yield persistence by arm, and the survival curves of species that died out in any run."""
    names = result["species"]
    rows = []
    for arm, a in result["arms"].items():
        of = [a["per_species"][s] for s in names]
        gone = [f"{x['extinctions']} of {a['n']}, median {number(x['median_extinction'])}" for x in of]
        rows.append([arm, a["n"], f"{a['ticks']:,}", a["persisted"], interval(a["persistence"]), *gone])
    head = ["arm", "runs", "ticks", "all persist", "share", *(f"{s} extinct" for s in names)]
    yield f"<h2>Persistence</h2>\n{table(head, rows)}"
    until = max(arm["ticks"] for arm in result["arms"].values())
    for s in names:
        if any(c.died.any() for c in curves[s].values()):
            curve = figures.survival(curves[s], until, f"{s} persists")
            yield drawn(curve, out / "figures" / f"survival_{s}.svg", _CURVE.format(s))


def _crossed(out: Path, result: dict[str, Any], runs: Mapping[str, Grid]) -> list[str]:
    """Return the section on crossed designs: results by training seed, and the sources of variance."""
    grids = {arm: a["crossed"] for arm, a in result["arms"].items() if "crossed" in a}
    if not grids:
        return []
    blocks = ["<h2>Training seed and world seed</h2>"]
    for arm, c in grids.items():
        worlds = len(c["world_seeds"])
        each = ", ".join(f"{seed}: {kept}" for seed, kept in c["persisted_by_training_seed"].items())
        blocks.append(
            f"<p>{escape(arm)}: {len(c['training_seeds'])} training seeds × {worlds} world seeds. Number of "
            f"runs (of {worlds}) in which all species persist, by training seed: {each}. For estimating this "
            f"fraction, the {len(c['training_seeds']) * worlds} runs are as informative as "
            f"{number(c['effective_runs'])} independent runs.</p>"
        )
        curve = seed_grid.persistence(runs[arm], f"{arm}: all species persist")
        cells = seed_grid.lifetimes(runs[arm], f"{arm}: first extinction")
        blocks.append(drawn(curve, out / "figures" / f"persistence_{arm}.svg", _BY_SEED))
        blocks.append(drawn(cells, out / "figures" / f"first_extinction_{arm}.svg", _CELLS))
    rows = [
        [arm, outcome, x["n"], *(_share(x["share"][effect]) for effect in EFFECTS)]
        for arm, c in grids.items()
        for outcome, x in c["variance_shares"].items()
    ]
    return [*blocks, _SHARES, table(["arm", "outcome", "runs", *EFFECTS], rows)] if rows else blocks


def _against(result: dict[str, Any]) -> list[str]:
    """Return the section on differences from the reference."""
    gaps = [
        [arm, s, interval(x["lifetime"]), number(x["log_rank_p"]), interval(x["mean_number"])]
        for arm, e in result["effects"].items()
        for s, x in e["per_species"].items()
    ]
    if not gaps:
        return []
    share = [[arm, interval(e["persistence"])] for arm, e in result["effects"].items()]
    head = ["arm", "species", "difference in lifetime [ticks]", "log-rank p", "difference in mean number"]
    return [
        f"<h2>Differences from {escape(result['reference'])}</h2>",
        table(["arm", "difference in the fraction that persists (Newcombe)"], share),
        table(head, gaps),
    ]


def _seeds(loaded: Mapping[str, Sequence[Series]], grids: Mapping[str, Grid]) -> list[str]:
    """Return the section on the number of seeds. With several training seeds, these are the replicates."""
    reference, *others = loaded

    def of_seeds(arm: str, value: Callable[..., float]) -> np.ndarray:
        rows = grids[arm].runs if arm in grids else [loaded[arm]]
        values = np.array([[value(run) for run in row] for row in rows], float)
        values = values.mean(axis=1) if len(values) > 1 else values[0]
        return values[np.isfinite(values)]

    runs = [run for own in loaded.values() for run in own]
    outcomes: dict[str, Callable[..., float]] = {"all species persist": lambda run: run.persisted}
    for s in (s for s in runs[0].species if all(_there(own, s) for own in loaded.values())):
        outcomes[f"mean number of {s}"] = lambda run, s=s: float(run.of(s).mean())
    for name, kinds in measures.measured(*runs).items():
        for of in kinds:
            label = name if of == measures.WORLD else f"{name} of {of}"
            outcomes[f"mean {label}"] = partial(measures.run_mean, name=name, of=of)
    effects = [
        Effect(
            f"{arm} − {reference}: {label}" if others else label,
            of_seeds(arm, value),
            of_seeds(reference, value) if others else None,
            share=label == "all species persist",
        )
        for arm in others or [reference]
        for label, value in outcomes.items()
    ]
    crossed = bool(grids) and all(arm in grids and len(grids[arm].runs) > 1 for arm in loaded)
    return seeds_section(effects, "training seeds" if crossed else "seeds")


def _depth(out: Path, result: dict[str, Any], loaded: Mapping[str, Sequence[Series]]) -> list[str]:
    """Return the daily cycle of mean depth in each arm, for species that swim under a sun."""
    arms = result["arms"].items()
    depths = [(arm, s, x["depth"]) for arm, a in arms for s, x in a["per_species"].items() if "depth" in x]
    if not depths:
        return []
    names = [s for s in result["species"] if any(s == name for _, name, _ in depths)]
    hours = drawn(depth_figures.arms(loaded, names), out / "figures" / "depth.svg", _HOURS)
    words = ("amplitude", "along_day", "r")
    rows = [[arm, s, d["n"], *(interval(d[word]) for word in words)] for arm, s, d in depths]
    head = ["arm", "species", "runs with at least two days", "amplitude", "in phase with the sun"]
    head.append("correlation with light")
    return ["<h2>Depth over the day</h2>", _DEPTH, hours, table(head, rows)]


def _measured(out: Path, result: dict[str, Any], loaded: Mapping[str, Sequence[Series]]) -> list[str]:
    """Return the values of the world's reporters in each arm, and their differences from the reference."""
    if "measured" not in result:
        return []
    found, gaps = result["measured"]["arms"], result["measured"]["effects"]
    courses = drawn(measures.arms_figure(loaded), out / "figures" / "measured.svg", _REPORTED)
    rows = []
    for name, kinds in found.items():
        for of, arms in kinds.items():
            who = "the world" if of == measures.WORLD else of
            for arm, x in arms.items():
                gap = interval(gaps[name][of].get(arm))
                rows.append([name, who, arm, x["n"], interval(x["mean"]), gap])
    head = ["measured", "of", "arm", "runs", "mean", f"difference from {result['reference']}"]
    return ["<h2>Measured</h2>", courses, table(head, rows)]


def _cycles(result: dict[str, Any]) -> list[str]:
    """Return the section on cycles in each arm and lags between species."""
    rows, lags = [], []
    for arm, a in result["arms"].items():
        for s, x in a["per_species"].items():
            red, lenient = (f"{x[word]} of {x['long_enough']}" for word in ("cycling", "cycling_ar1"))
            ends = number(x["median_period"]), number(x["mean_number"])
            rows.append([arm, s, red, number(x["pooled_p"], 2), lenient, *ends])
        for pair, x in a["lags"].items():
            share, p = [x["median"], x["low"], x["high"]], a["coupling"].get(pair, {}).get("p")
            lags += [[arm, pair, x["n"], interval(share), number(p)]] * bool(x["n"])
    head = ["arm", "species", "cycling", "p over all seeds", "beyond AR(1)", "median period [ticks]"]
    blocks = ["<h2>Cycles</h2>", _PEAKS, table([*head, "mean number"], rows)]
    if lags:
        blocks += [_LAGS, table(["arm", "pair", "runs", "median lag", "coupling p"], lags)]
    return blocks
