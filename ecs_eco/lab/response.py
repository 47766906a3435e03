"""Responses of outcomes to the values varied in a sweep, with 95% intervals over seeds, and, for points drawn by
Sobol's or Morris's method, sensitivity indices, computed by SALib."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from itertools import combinations
from typing import Any

import numpy as np

from ecs_eco.analysis.palette import AXIS, INK, ON_CELL
from ecs_eco.analysis.seed_grid import mean_of_known, share_interval
from ecs_eco.analysis.style import DASHES, PALETTE, Axes, Figure, panels, styled
from ecs_eco.analysis.survival import Interval, wilson
from ecs_eco.lab.plan import Sample
from ecs_eco.lab.work import group

Row = Mapping[str, Any]


@dataclass(frozen=True)
class Outcome:
    """A column of the runs table that is shown in figures and on the page."""

    column: str
    label: str
    of: str = ""  # its species, "" for the world
    share: bool = False  # whether its value in each run is 0 or 1


@dataclass(frozen=True)
class Answer:
    """An outcome at one value: its mean over seeds, the interval of the mean, and the value in each run."""

    value: Any
    mean: Interval
    runs: tuple[float, ...]


def outcomes_of(rows: Sequence[Row], species: Sequence[str]) -> list[Outcome]:
    """Return the outcomes in a table of runs: persistence, population sizes, cycle periods, and reporters."""
    found = [Outcome("persisted", "fraction in which all persist", share=True)]
    found += [Outcome(f"{name}.mean", f"mean number of {name}", name) for name in species]
    found += [
        Outcome(f"{name}.period", f"period of {name} [ticks]", name)
        for name in species
        if sum(row[f"{name}.period"] is not None for row in rows) > len(rows) / 4
    ]
    known = {f"{name}.mean" for name in species}
    for column in rows[0]:
        if column.endswith(".mean") and column not in known:
            what = column.removesuffix(".mean")
            of = next((name for name in species if what.endswith(f".{name}")), "")
            label = f"{what.removesuffix('.' + of)} of {of}" if of else what
            found.append(Outcome(column, f"mean {label}", of))
    return found


def turnover_of(rows: Sequence[Row], species: Sequence[str]) -> list[Outcome]:
    """Return the outcomes births and deaths by cause, such as "deer: harvested" for a catch."""
    return [
        Outcome(column, f"{name}: {what.removeprefix('died.')}", name)
        for column in rows[0]
        for name, _, what in [column.partition(".")]
        if name in species and (what.startswith("died.") or what == "births")
    ]


def values_of(rows: Iterable[Row], key: str) -> list[Any]:
    """Return the values of a key: numbers sorted, other values in order of appearance."""
    values = list({json.dumps(row[key]): row[key] for row in rows}.values())
    return sorted(values) if _are_numbers(values) else values


def answers(rows: Sequence[Row], key: str, outcome: Outcome, each: str = "") -> list[Answer]:
    """Return an outcome at each value of a key, or, if `each` is "point", at each point, ordered by this value:
    its mean over all other varied values, averaged over seeds."""
    found, values = [], values_of(rows, key)
    for part in group(rows, lambda row: json.dumps(row[each or key])).values():
        runs = tuple(float(row[outcome.column]) for row in part if row[outcome.column] is not None)
        found.append(Answer(part[0][key], interval(part, outcome), runs))
    return sorted(found, key=lambda answer: values.index(answer.value))


def interval(rows: Sequence[Row], outcome: Outcome) -> Interval:
    """Return the mean of an outcome over training and world seeds with its 95% interval, NaN without values."""
    table = _table(rows, outcome.column)
    known = table[np.isfinite(table)]
    if outcome.share and known.size and np.isin(known, (0.0, 1.0)).all():
        crossed = known.size == table.size and len(table) > 1
        return share_interval(table) if crossed else wilson(known.sum(), known.size)
    mean = mean_of_known(table)
    return Interval(mean.value, max(mean.low, 0.0), min(mean.high, 1.0)) if outcome.share else mean


def of_seeds(rows: Sequence[Row], column: str) -> np.ndarray:
    """Return the means of a column by training seed or, if nothing is trained, by world seed, without gaps."""
    table = _table(rows, column)
    table = table if len(table) > 1 else table.T
    return np.array([np.mean(known) for row in table if (known := row[np.isfinite(row)]).size])


def _table(rows: Sequence[Row], column: str) -> np.ndarray:
    """Return the means of a column by training seed and world seed."""
    training = sorted({row["training_seed"] or 0 for row in rows})
    worlds = sorted({row["world_seed"] for row in rows})
    known = [row for row in rows if row[column] is not None]
    parts = group(known, lambda row: (row["training_seed"] or 0, row["world_seed"]))
    means = {seeds: np.mean([float(row[column]) for row in part]) for seeds, part in parts.items()}
    return np.array([[means.get((a, b), np.nan) for b in worlds] for a in training])


FEW = 12  # with more values, each point is drawn instead of one point per value
CELLS = 9 * 9  # maximum number of heat-map cells that show numbers
LABELS = 48  # maximum number of characters under a panel before labels are rotated


def short(key: str) -> str:
    """Return a key without the prefix "species."."""
    return key.removeprefix("species.")


@styled
def responses(
    rows: Sequence[Row], keys: Sequence[str], outcomes: Sequence[Outcome], hue: Mapping[str, str]
) -> Figure:
    """Plot a panel for each outcome (rows) and key (columns), with a line for each treatment: the mean and
    95% interval at each value, and runs as dots."""
    figure, axes = panels(
        len(outcomes),
        len(keys),
        3.9 * len(keys) + 1.2,
        2.15 * len(outcomes) + 0.8,
        sharex="col",
        sharey="row",
    )
    parts = group(rows, lambda row: row["treatment"])
    for column, key in enumerate(keys):
        values = values_of(rows, key)
        for ax, outcome in zip(axes[:, column], outcomes, strict=True):
            for i, (treatment, part) in enumerate(parts.items()):
                color = hue.get(outcome.of, INK) if len(parts) == 1 else PALETTE[(2, 3, 0, 4, 1, 5, 6)[i % 7]]
                _response(ax, part, key, values, outcome, color, i, len(parts), treatment)
        _values_axis(axes[-1, column], key, values)
    for beside, outcome in zip(axes, outcomes, strict=True):  # after all columns, whose limits are shared
        if outcome.share:
            beside[0].set_ylim(-0.06, 1.06)
        elif min(ax.dataLim.y0 for ax in beside) >= 0:
            beside[0].set_ylim(0, None)
        beside[0].set_ylabel(outcome.label, wrap=True)
    figure.align_ylabels()
    if len(parts) > 1:
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=min(5, len(labels)))
    return figure


def _response(
    ax: Axes,
    rows: Sequence[Row],
    key: str,
    values: list[Any],
    outcome: Outcome,
    color: str,
    number: int,
    of: int,
    label: str,
) -> None:
    """Plot the responses of one treatment, offset from those of the other treatments."""
    each = len(values) <= FEW
    found = [a for a in answers(rows, key, outcome, "" if each else "point") if np.isfinite(a.mean.value)]
    x = _places(values, [answer.value for answer in found])
    apart = np.diff(np.unique(_places(values, values)))
    gap = float(apart.min()) if apart.size else 1.0  # smallest distance between values
    x = x + (number - (of - 1) / 2) * 0.06 * gap
    middle, low, high = (
        np.array([getattr(a.mean, end) for a in found], float) for end in ("value", "low", "high")
    )
    errors = np.nan_to_num(np.stack([middle - low, high - middle]))
    if not outcome.share and each:
        spread = np.concatenate(
            [np.full(len(a.runs), place) for a, place in zip(found, x, strict=True)] or [np.zeros(0)]
        )
        ax.plot(
            spread + 0.02 * gap,
            [run for a in found for run in a.runs],
            ".",
            ms=4,
            color=color,
            alpha=0.35,
            mew=0,
            zorder=1,
        )
    *_, bars = ax.errorbar(
        x,
        middle,
        errors.clip(0),
        color=color,
        marker="o",
        ms=5 if each else 3.5,
        lw=1.6,
        elinewidth=1.3 if each else 0.8,
        capsize=2.5 if each else 0,
        ls=DASHES[number % len(DASHES)] if each and _are_numbers(values) else "none",
        label=label,
        zorder=3,
    )
    if not each:
        bars[0].set_alpha(0.35)


def _places(values: list[Any], wanted: Sequence[Any]) -> np.ndarray:
    """Return the positions of values on an axis: numbers at their values, other values side by side."""
    return np.array(wanted if _are_numbers(values) else [values.index(value) for value in wanted], float)


def _are_numbers(values: Sequence[Any]) -> bool:
    return all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)


def _values_axis(ax: Axes, key: str, values: list[Any]) -> None:
    ax.set_xlabel(short(key))
    names, are_numbers = [_written(v) for v in values], _are_numbers(values)
    if not are_numbers:
        turned = sum(map(len, names)) > LABELS
        ax.set_xticks(range(len(values)), names, rotation=30 * turned, ha="right" if turned else "center")
    elif len(values) <= 6:
        turned = min(np.diff(values), default=1) < 0.04 * max(map(len, names)) * np.ptp(values)
        ax.set_xticks(values, names, rotation=45 * turned, ha="right" if turned else "center")
    ax.margins(x=0.08 if are_numbers else 0.15)


def _written(value: Any) -> str:
    if _are_numbers([value]):
        return f"{value:,}" if isinstance(value, int) else f"{value:.4g}"
    return str(value)


def pairs_of(rows: Sequence[Row], keys: Sequence[str], most: int = 6) -> list[tuple[str, str]]:
    """Return the pairs of keys that each have numeric values or only a few values."""
    useful = [key for key in keys if _are_numbers(values := values_of(rows, key)) or len(values) <= FEW]
    return list(combinations(useful, 2))[:most]


@styled
def heat(rows: Sequence[Row], pair: tuple[str, str], outcomes: Sequence[Outcome]) -> Figure:
    """Plot the means of outcomes (panels) against two keys, as grid cells or as dots."""
    parts = group(rows, lambda row: row["treatment"])
    wide = min(3, len(outcomes))
    high = -(-len(outcomes) // wide)
    figure, axes = panels(high * len(parts), wide, 3.75 * wide + 0.4, 3.1 * high * len(parts) + 0.3)
    grid = all(len(values_of(rows, key)) <= FEW for key in pair)
    limits = {o: _limits(rows, pair, o) for o in outcomes}
    for i, (treatment, part) in enumerate(parts.items()):
        for j, outcome in enumerate(outcomes):
            ax = axes[i * high + j // wide, j % wide]
            drawn = (_cells if grid else _dots)(ax, part, pair, outcome, limits[outcome])
            figure.colorbar(drawn, ax=ax, pad=0.02)
            ax.set(xlabel=short(pair[0]), ylabel=short(pair[1]))
            ax.set_title(outcome.label if len(parts) == 1 else f"{treatment}: {outcome.label}", fontsize=9.5)
            ax.grid(visible=False)
        for ax in axes[i * high : (i + 1) * high].flat[len(outcomes) :]:
            ax.set_visible(False)
    return figure


def _limits(rows: Sequence[Row], pair: tuple[str, str], outcome: Outcome) -> tuple[float, float]:
    """Return the limits of an outcome's color scale, the same for all treatments."""
    if outcome.share:
        return 0.0, 1.0
    cells = group(rows, lambda row: (row["treatment"], *(str(row[key]) for key in pair)))
    means = [m for part in cells.values() if np.isfinite(m := interval(part, outcome).value)]
    return (min(means), max(means)) if means else (0.0, 1.0)


def _cells(
    ax: Axes, rows: Sequence[Row], pair: tuple[str, str], outcome: Outcome, limits: tuple[float, float]
) -> Any:
    across, up = (values_of(rows, key) for key in pair)
    means = np.full((len(up), len(across)), np.nan)
    for i, b in enumerate(up):
        for j, a in enumerate(across):
            here = [row for row in rows if row[pair[0]] == a and row[pair[1]] == b]
            means[i, j] = interval(here, outcome).value  # NaN without rows
    drawn = ax.imshow(means, origin="lower", aspect="auto", cmap="viridis", vmin=limits[0], vmax=limits[1])
    ax.set_xticks(
        range(len(across)),
        [_written(v) for v in across],
        rotation=30 if sum(len(_written(v)) for v in across) > 24 else 0,
    )
    ax.set_yticks(range(len(up)), [_written(v) for v in up])
    if means.size <= CELLS:
        middle = sum(limits) / 2
        for (i, j), mean in np.ndenumerate(means):
            if np.isfinite(mean):
                ax.text(
                    j,
                    i,
                    _cell(mean, outcome),
                    ha="center",
                    va="center",
                    fontsize=9,
                    color=ON_CELL[bool(mean >= middle)],
                )
    return drawn


def _cell(mean: float, outcome: Outcome) -> str:
    if outcome.share:
        return f"{mean:.2f}" if mean < 1 else "1"
    return f"{mean:,.0f}" if abs(mean) >= 100 else f"{mean:.3g}"


def _dots(
    ax: Axes, rows: Sequence[Row], pair: tuple[str, str], outcome: Outcome, limits: tuple[float, float]
) -> Any:
    parts = list(group(rows, lambda row: row["point"]).values())
    x, y = ([part[0][key] for part in parts] for key in pair)
    return ax.scatter(
        x,
        y,
        c=[interval(part, outcome).value for part in parts],
        cmap="viridis",
        s=46,
        edgecolor=AXIS,
        lw=0.5,
        vmin=limits[0],
        vmax=limits[1],
    )


INDEX_NAMES = {"sobol": ("first-order index", "total index"), "morris": ("μ*", "σ")}
Indices = Mapping[str, Sequence[Interval]]  # key: its two indices, as in INDEX_NAMES


def indices(sample: Sample, y: np.ndarray) -> Indices:
    """Return the indices of each key with 95% intervals (bootstrap over points; σ has none), given the outcome
    at each point. Sobol: the shares of the variance explained by a value alone, and with its interactions
    (Saltelli et al. 2010). Morris: the mean and standard deviation of the changes in the outcome per range
    (Campolongo, Cariboni and Saltelli 2007)."""
    analyze = import_module(f"SALib.analyze.{sample.design}").analyze
    if sample.design == "sobol":
        found = analyze(sample.problem, y, calc_second_order=False, seed=1)
        columns = [found[name] for name in ("S1", "S1_conf", "ST", "ST_conf")]
    else:
        found = analyze(sample.problem, sample.shares(), y, seed=1)
        columns = [
            found["mu_star"],
            found["mu_star_conf"],
            found["sigma"],
            np.full(len(sample.ranges), np.nan),
        ]
    return {
        key: [Interval(x, x - half, x + half) for x, half in (numbers[:2], numbers[2:])]
        for key, numbers in zip(sample.ranges, np.transpose(columns).astype(float).tolist(), strict=True)
    }


def indices_of(
    sample: Sample, rows: Sequence[Row], outcomes: Sequence[Outcome]
) -> Iterator[tuple[str, Outcome, Indices]]:
    """Yield the indices of means over seeds, for each treatment and each complete outcome that varies."""
    for treatment, part in group(rows, lambda row: row["treatment"]).items():
        points = [own for _, own in sorted(group(part, lambda row: row["point"]).items())]
        for outcome in outcomes:
            y = np.array([interval(own, outcome).value for own in points])
            if len(y) == sample.size and np.isfinite(y).all() and np.ptp(y) > 0:
                yield treatment, outcome, indices(sample, y)


@styled
def index_bars(design: str, found: Sequence[tuple[str, Outcome, Indices]]) -> Figure:
    """Plot a panel for each treatment and outcome, with both indices of each key."""
    figure, axes = panels(
        len(found), 1, 8, 0.6 + len(found) * (0.9 + 0.35 * len(found[0][2])), sharex=design == "sobol"
    )
    for ax, (treatment, outcome, own) in zip(axes[:, 0], found, strict=True):
        for i, name in enumerate(INDEX_NAMES[design]):
            at, means = np.arange(len(own)) + 0.4 * i, np.array([both[i] for both in own.values()])
            error = np.nan_to_num(means[:, 2] - means[:, 0])
            ax.barh(at, means[:, 0], 0.38, xerr=error, color=PALETTE[i], ecolor=INK, label=name)
        ax.set_yticks(np.arange(len(own)) + 0.2, [short(key) for key in own])
        ax.invert_yaxis()
        ax.set_title(f"{outcome.label} ({treatment})", fontsize=9.5)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=2)
    return figure
