"""Values of reporters over time in one or several runs, differences between arms, and recorded fields."""

from collections.abc import Callable, Collection, Mapping, Sequence
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from ecs_eco.analysis.figures import interventions, mark
from ecs_eco.analysis.page import number, table
from ecs_eco.analysis.palette import INK
from ecs_eco.analysis.runs import Series, tables
from ecs_eco.analysis.seed_grid import mean_interval, mean_of_known
from ecs_eco.analysis.style import Figure, colors_of, grid_of_arms, many_and_one, over_ticks, styled
from ecs_eco.analysis.survival import Interval, bootstrap_difference

Rows = Sequence[Sequence[Series]]  # an arm's runs by training seed
WORLD = "(world)"
"""Used instead of a species for values of the whole world."""


def measured(*runs: Series) -> dict[str, list[str]]:
    """Return the reporters that all these runs share: reporter → the species with values, or only WORLD."""
    out = {}
    for name in (name for name in runs[0].reporters if all(name in run.columns for run in runs)):
        columns = [run.columns[name] for run in runs]
        alike = all(np.array_equal(c, np.broadcast_to(c[:, :1], c.shape), equal_nan=True) for c in columns)
        known = [any(np.isfinite(c[:, i]).any() for c in columns) for i in range(len(runs[0].species))]
        out[name] = [WORLD] if alike else list(compress(runs[0].species, known))
    return out


def course(run: Series, name: str, of: str) -> np.ndarray:
    """Return a reporter's value in each tick for a species or the WORLD, (ticks,); missing values are NaN."""
    return run.columns[name][:, 0] if of == WORLD else run.of(of, name)


def run_mean(run: Series, name: str, of: str) -> float:
    """Return the mean over the ticks of a run that have a value, or NaN if there are none."""
    values = course(run, name, of)
    values = values[np.isfinite(values)]
    return float(values.mean()) if values.size else float("nan")


def rows(series: Series) -> str:
    """Return a table with a row for each reporter and species: first, mean, minimum, maximum, last."""
    out = []
    for name, kinds in measured(series).items():
        for of in kinds:
            values = course(series, name, of)
            values = values[np.isfinite(values)]
            if not values.size:
                values = np.array([np.nan])
            numbers = values[0], values.mean(), values.min(), values.max(), values[-1]
            out.append([name, "the world" if of == WORLD else of, *map(number, numbers)])
    return table(["measured", "of", "first tick", "mean", "minimum", "maximum", "last tick"], out)


def lines(series: Series) -> list[str]:
    """Return a line for each reporter and species: its mean over a run, and its last value."""
    return [
        f"{name}{'' if of == WORLD else f' of {of}'}: {number(run_mean(series, name, of))} on average, "
        f"{number(course(series, name, of)[-1])} at the end"
        for name, kinds in measured(series).items()
        for of in kinds
    ]


@styled
def figure(series: Series) -> Figure:
    """Draw a panel for each reporter, with a line for each species."""
    kinds, hue = measured(series), colors_of(series)
    figure, axes = over_ticks(len(kinds), 1.9, 0.5)
    for ax, (name, named) in zip(axes, kinds.items(), strict=True):
        for of in named:
            ax.plot(series.ticks, course(series, name, of), color=hue.get(of, INK), label=of)
        ax.set_ylabel(name)
        ax.margins(x=0)
        if named != [WORLD]:
            ax.legend(loc="upper right")
    mark(axes[0], interventions(series))
    return figure


def fields(run: Path | str) -> list[str]:
    """Return a table with the mean and standard deviation of each field listed in the world's `record` key."""
    births, snapshots = list(tables(run, "births")), list(tables(run, "snapshots"))
    names = [name for part in births[:1] for name in part.column_names if "." in name]
    if not names:
        return []
    moments = [
        _moments(births, names),
        _moments(list(tables(run, "deaths")), names),
        _moments(snapshots[:1], names, pc.min),
        _moments(snapshots[-1:], names, pc.max),
    ]
    known = dict.fromkeys(
        (s, name) for name in names for found in moments for s, field in found if field == name
    )
    rows = [[name, s, *(found.get((s, name), "–") for found in moments)] for s, name in known]
    head = ["field", "species", "at birth", "at death", "in the first snapshot", "in the last snapshot"]
    return ["<h2>Recorded fields</h2>", table(head, rows), "<p class='under'>Mean ± standard deviation.</p>"]


def _moments(
    parts: list[pa.Table], names: list[str], which: Callable[[pa.Array], pa.Scalar] | None = None
) -> dict[tuple[str, str], str]:
    """Return mean ± standard deviation by species and field, over all rows or the tick chosen by `which`."""
    if not parts:
        return {}
    columns = ["tick", "species", *names]
    rows = pa.concat_tables(
        pa.table({n: t[n].cast(pa.float64()) if n in names else t[n] for n in columns}) for t in parts
    )
    if which is not None:
        rows = rows.filter(pc.equal(rows["tick"], which(rows["tick"])))
    wanted = [(name, how) for name in names for how in ("mean", "stddev")]
    out = {}
    for row in rows.group_by("species", use_threads=False).aggregate(wanted).to_pylist():
        for name in names:
            if (mean := row[f"{name}_mean"]) is not None:
                out[row["species"], name] = f"{number(mean)} ± {number(row[f'{name}_stddev'])}"
    return out


@styled
def arms_figure(runs: Mapping[str, Sequence[Series]]) -> Figure:
    """Plot each reporter (rows) over time by arm (columns): thin lines for runs, thick for medians."""
    every = [run for members in runs.values() for run in members]
    kinds, hue = measured(*every), colors_of(every[0])
    figure, axes = grid_of_arms(runs, list(kinds), (4, 1.9), 0.6, sharey="row")
    for column, members in zip(axes.T, runs.values(), strict=True):
        length = min(len(run.ticks) for run in members)
        for ax, (name, named) in zip(column, kinds.items(), strict=True):
            for of in named:
                courses = np.array([course(run, name, of)[:length] for run in members])
                x, color = members[0].ticks[:length], hue.get(of, INK)
                median = np.ma.median(np.ma.masked_invalid(courses), axis=0).filled(np.nan)
                many_and_one(ax, x, courses, median, color, label=of)
            ax.margins(x=0)
    for ax, named in zip(axes[:, 0], kinds.values(), strict=True):
        if named != [WORLD]:
            ax.legend(loc="upper right")
    return figure


def of_arms(arms: Mapping[str, Rows]) -> dict[str, Any]:
    """Return, by reporter, species or WORLD, and arm, the "mean" with its interval, and "n", the number of
    runs with a value. Means are over time, then over runs. Both kinds of seeds are replicates."""
    kinds = measured(*(run for rows in arms.values() for row in rows for run in row))
    out: dict[str, Any] = {}
    for name, named in kinds.items():
        for of in named:
            each = {arm: _means(rows, name, of) for arm, rows in arms.items()}
            out.setdefault(name, {})[of] = {
                arm: {"mean": mean_of_known(values) if n else None, "n": n}
                for arm, values in each.items()
                for n in [int(np.isfinite(values).sum())]
            }
    return out


def effects(arms: Mapping[str, Rows], grids: Collection[str], seed: int) -> dict[str, Any]:
    """Return the difference in means between each arm and the first, with keys as in `of_arms`, from a bootstrap
    over runs or, with several training seeds, over cells with the same seeds (None if arms share no seeds)."""
    kinds = measured(*(run for rows in arms.values() for row in rows for run in row))
    reference, *others = arms

    def difference(arm: str, name: str, of: str) -> Interval | None:
        one, two = (_means(arms[a], name, of) for a in (arm, reference))
        if arm not in grids and reference not in grids:
            return bootstrap_difference(one[np.isfinite(one)], two[np.isfinite(two)], seed=seed)
        seeds = [[int(run.manifest["seed"]) for run in arms[a][0]] for a in (arm, reference)]
        same = seeds[0] == seeds[1] and (len(one) == len(two) or 1 in (len(one), len(two)))
        return mean_interval(one - two) if same and np.isfinite(one - two).all() else None

    return {
        name: {of: {arm: difference(arm, name, of) for arm in others} for of in named}
        for name, named in kinds.items()
    }


def _means(rows: Rows, name: str, of: str) -> np.ndarray:
    return np.array([[run_mean(run, name, of) for run in row] for row in rows])
