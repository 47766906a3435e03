"""The page of a comparison: compare.json, compare.html and figures/."""

import json
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from ecs_eco.analysis import compare_genes, depth_figures, figures, measures, seed_grid
from ecs_eco.analysis.page import drawn, interval, number, page, table, verdict, write_text
from ecs_eco.analysis.runs import Series
from ecs_eco.analysis.seed_grid import EFFECTS, Grid
from ecs_eco.analysis.survival import SurvivalCurve


def write(
    out: Path,
    result: dict[str, Any],
    loaded: Mapping[str, Sequence[Series]],
    curves: Mapping[str, Mapping[str, SurvivalCurve]],
    grids: Mapping[str, Grid],
    genes: Sequence[compare_genes.Gene] = (),
) -> None:
    """Write what `compare` found: runs, survival curves, grids and genes are given besides the result."""
    write_text(out / "compare.json", json.dumps(result, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    by_seed = {arm: _draw_grid(out / "figures", arm, grid) for arm, grid in grids.items()}
    blocks = [
        *_head(result),
        *_who(result, _draw_survival(out, result, curves)),
        *_crossed(result, by_seed),
        *_against(result),
        *_depth(out, result, loaded),
        "<h2>Numbers</h2>",
        drawn(figures.arms(loaded), out / "figures" / "numbers.svg", _MEANS),
        *_measured(out, result, loaded),
        *compare_genes.blocks(out, genes, result.get("genes", {}), result["reference"]),
        *_cycles(result),
    ]
    write_text(out / "compare.html", page("Comparison of " + ", ".join(result["arms"]), *blocks))


def _share(x: Sequence[float]) -> str:
    return "–" if x[0] is None else f"{x[0]:.2f} ({x[1]:.2f} … {x[2]:.2f})"


_CURVE = "Share of runs in which {} lives (Kaplan–Meier, 95 % bands)."
_BY_SEED = (
    "Share of runs in which all species live: all runs thick, "
    "with a band over both kinds of seeds (95 %); each training seed thin."
)
_CELLS = "The tick of the first extinction, and the species, by training seed and world seed."
_MEANS = "Numbers over time: every run thin, the median over runs thick."
_REPORTED = (
    "What the world's reporters measured, over time: every run thin, the median over runs thick. "
    "The table has means over runs of the mean over a run (95 %)."
)
_HOURS = (
    "Mean depth over the hours of the day, the first day left out: every run thin, "
    "the mean over runs thick; grey is night."
)
_SHARES = (
    "<p>Where the variance comes from: shares of training seed, of world seed and of the rest, "
    "which is chance and the interaction of both. “Persisted” counts as 0 and 1, on the linear scale; "
    "a time that the end of the run cut off counts as the whole run; a period is given where a run cycles. "
    "A dash: nothing varies. Intervals are from a two-way bootstrap.</p>"
)
_DEPTH = (
    "<p>A cosine of a day fitted to mean depth: its amplitude as a share of the water; "
    "the part of it along the sun, above 0 where they are deepest at noon and below 0 where at midnight; "
    "and the correlation of mean depth with light. Means over runs (95 %).</p>"
)
_PEAKS = (
    "<p>Runs whose spectrum has a peak beyond red noise that only relaxes (p ≤ .05 in each run; "
    "by luck 1 in 20), and beyond AR(1), which calls smooth series periodic.</p>"
)


def _draw_survival(
    out: Path, result: dict[str, Any], curves: Mapping[str, Mapping[str, SurvivalCurve]]
) -> list[str]:
    """Survival curves of the species that died out in some run, as HTML."""
    until = max(arm["ticks"] for arm in result["arms"].values())
    shown = [s for s in result["species"] if any(c.died.any() for c in curves[s].values())]
    return [
        drawn(
            figures.survival(curves[s], until, f"{s} persists"),
            out / "figures" / f"survival_{s}.svg",
            _CURVE.format(s),
        )
        for s in shown
    ]


def _draw_grid(folder: Path, arm: str, grid: Grid) -> list[str]:
    """Survival by training seed and the map of first extinctions of one arm, as HTML."""
    curve = seed_grid.persistence(grid, f"{arm}: all species persist")
    cells = seed_grid.lifetimes(grid, f"{arm}: first extinction")
    return [
        drawn(curve, folder / f"persistence_{arm}.svg", _BY_SEED),
        drawn(cells, folder / f"first_extinction_{arm}.svg", _CELLS),
    ]


def _head(result: dict[str, Any]) -> list[str]:
    """The head of the page: in how many runs of each arm all species persisted, and which died out of what."""
    arms = result["arms"]
    lines = [f"{arm}: {text}" for arm, text in result["opening"].items()]
    return [
        f"<h1>Comparison of {len(arms)} arms</h1>",
        verdict(lines, any(a["persisted"] < a["n"] for a in arms.values())),
        "<p class='under'>Seeds are the replicates. Intervals are 95 %.</p>",
        *(
            f"<p class='under'>{escape(arm)} runs with {escape(a['policies'])}.</p>"
            for arm, a in arms.items()
            if "policies" in a
        ),
    ]


def _who(result: dict[str, Any], pictures: Sequence[str]) -> list[str]:
    """Persistence by arm: runs in which all persisted, and when each species died out."""
    names = result["species"]
    rows = [
        [arm, a["n"], f"{a['ticks']:,}", a["persisted"], interval(a["persistence"])]
        + [
            f"{x['extinctions']} of {a['n']}, median {number(x['median_extinction'])}"
            for x in (a["per_species"][s] for s in names)
        ]
        for arm, a in result["arms"].items()
    ]
    head = ["arm", "runs", "ticks", "all persist", "share", *(f"{s} extinct" for s in names)]
    return ["<h2>Who persists</h2>", table(head, rows), *pictures]


def _crossed(result: dict[str, Any], by_seed: Mapping[str, Sequence[str]]) -> list[str]:
    """The crossed design of the arms that have one: by training seed, and where the variance comes from."""
    grids = {arm: a["crossed"] for arm, a in result["arms"].items() if "crossed" in a}
    if not grids:
        return []
    blocks = ["<h2>Training seed and world seed</h2>"]
    for arm, c in grids.items():
        worlds = len(c["world_seeds"])
        each = ", ".join(f"{seed}: {kept}" for seed, kept in c["persisted_by_training_seed"].items())
        blocks.append(
            f"<p>{escape(arm)}: {len(c['training_seeds'])} training seeds × {worlds} world seeds. "
            f"Runs of {worlds} in which all persist, by training seed: {each}. "
            f"The {len(c['training_seeds']) * worlds} runs say as much about that share as "
            f"{number(c['effective_runs'])} independent ones would.</p>"
        )
        blocks += by_seed[arm]
    rows = [
        [arm, outcome, x["n"], *(_share(x["share"][effect]) for effect in EFFECTS)]
        for arm, c in grids.items()
        for outcome, x in c["variance_shares"].items()
    ]
    return [*blocks, _SHARES, table(["arm", "outcome", "runs", *EFFECTS], rows)] if rows else blocks


def _against(result: dict[str, Any]) -> list[str]:
    """What differs from the reference."""
    gaps = [
        [arm, s, interval(x["lifetime"]), number(x["log_rank_p"]), interval(x["mean_number"])]
        for arm, e in result["effects"].items()
        for s, x in e["per_species"].items()
    ]
    if not gaps:
        return []
    share = [[arm, interval(e["persistence"])] for arm, e in result["effects"].items()]
    return [
        f"<h2>Against {escape(result['reference'])}</h2>",
        table(["arm", "share that persists, difference (Newcombe)"], share),
        table(["arm", "species", "ticks lived, difference", "log-rank p", "mean number, difference"], gaps),
    ]


def _depth(out: Path, result: dict[str, Any], loaded: Mapping[str, Sequence[Series]]) -> list[str]:
    """How mean depth follows the day in each arm, of species that swim under a sun."""
    depths = [
        (arm, s, x["depth"])
        for arm, a in result["arms"].items()
        for s, x in a["per_species"].items()
        if "depth" in x
    ]
    if not depths:
        return []
    names = [s for s in result["species"] if any(s == name for _, name, _ in depths)]
    hours = drawn(depth_figures.arms(loaded, names), out / "figures" / "depth.svg", _HOURS)
    rows = [
        [arm, s, d["n"], *(interval(d[k]) for k in ("amplitude", "along_day", "r"))] for arm, s, d in depths
    ]
    head = ["arm", "species", "runs with two days", "amplitude", "along the sun", "correlation with light"]
    return ["<h2>Depth over the day</h2>", _DEPTH, hours, table(head, rows)]


def _measured(out: Path, result: dict[str, Any], loaded: Mapping[str, Sequence[Series]]) -> list[str]:
    """What the world's reporters measured in each arm, and how it differs from the reference."""
    if "measured" not in result:
        return []
    found, gaps = result["measured"]["arms"], result["measured"]["effects"]
    courses = drawn(measures.arms_figure(loaded), out / "figures" / "measured.svg", _REPORTED)
    rows = [
        [
            name,
            "the world" if of == measures.WORLD else of,
            arm,
            x["n"],
            interval(x["mean"]),
            interval(gaps[name][of].get(arm)),
        ]
        for name, kinds in found.items()
        for of, arms in kinds.items()
        for arm, x in arms.items()
    ]
    head = ["measured", "of", "arm", "runs", "mean", f"difference from {result['reference']}"]
    return ["<h2>Measured</h2>", courses, table(head, rows)]


def _cycles(result: dict[str, Any]) -> list[str]:
    """Cycles by arm, and which species follows which."""
    rows = [
        [
            arm,
            s,
            f"{x['cycling']} of {x['long_enough']}",
            number(x["pooled_p"], 2),
            f"{x['cycling_ar1']} of {x['long_enough']}",
            number(x["median_period"]),
            number(x["mean_number"]),
        ]
        for arm, a in result["arms"].items()
        for s, x in a["per_species"].items()
    ]
    head = [
        "arm",
        "species",
        "cycling",
        "p over all seeds",
        "beyond AR(1)",
        "median period [ticks]",
        "mean number",
    ]
    blocks = ["<h2>Cycles</h2>", _PEAKS, table(head, rows)]
    lags = [
        [
            arm,
            pair,
            x["n"],
            interval([x["median"], x["low"], x["high"]]),
            number(a["coupling"].get(pair, {}).get("p")),
        ]
        for arm, a in result["arms"].items()
        for pair, x in a["lags"].items()
        if x["n"]
    ]
    if lags:
        blocks.append(
            "<p>Lags as share of the period, over cycling runs; "
            "p tests the pair against pairs from different runs.</p>"
        )
        blocks.append(table(["arm", "pair", "runs", "median lag", "coupling p"], lags))
    return blocks
