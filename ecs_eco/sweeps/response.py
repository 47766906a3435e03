"""How outcomes of runs respond to what a sweep varied, with 95 % intervals over seeds."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ecs_eco.analysis.seed_grid import mean_interval, share_interval
from ecs_eco.analysis.survival import Interval, wilson

Row = Mapping[str, Any]


@dataclass(frozen=True)
class Outcome:
    """A column of the table that figures and page show."""

    column: str
    label: str
    of: str = ""  # the species, "" for the world
    share: bool = False  # whether it is 0 or 1 in each run


@dataclass(frozen=True)
class Answer:
    """An outcome at one value: its mean over seeds, the interval of that, and each run's own."""

    value: Any
    mean: Interval
    runs: tuple[float, ...]


def outcomes_of(rows: Sequence[Row], species: Sequence[str]) -> list[Outcome]:
    """Return what a table of runs holds: persistence, numbers, periods, and what reporters measured."""
    found = [Outcome("persisted", "share in which all persist", share=True)]
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


def values_of(rows: Iterable[Row], key: str) -> list[Any]:
    """Return the values of a key, numbers in order, others as they come."""
    values = list({json.dumps(row[key]): row[key] for row in rows}.values())
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
    return sorted(values) if numbers else values


def answers(rows: Sequence[Row], key: str, outcome: Outcome) -> list[Answer]:
    """Return an outcome at each value of a key: mean and interval over seeds of means over all else."""
    return [
        Answer(value, interval(part, outcome), tuple(_numbers(part, outcome)))
        for value in values_of(rows, key)
        if (part := [row for row in rows if row[key] == value])
    ]


def by_point(rows: Sequence[Row], key: str, outcome: Outcome) -> list[Answer]:
    """Return an outcome at each point, in the order of a key's values."""
    parts: dict[int, list[Row]] = {}
    for row in rows:
        parts.setdefault(row["point"], []).append(row)
    return sorted(
        (
            Answer(part[0][key], interval(part, outcome), tuple(_numbers(part, outcome)))
            for part in parts.values()
        ),
        key=lambda answer: answer.value,
    )


def interval(rows: Sequence[Row], outcome: Outcome) -> Interval:
    """Return the mean of an outcome over seeds with its 95 % interval, NaN where no run has a number;
    training seeds, where there are some, and world seeds are replicates."""
    table = _table(rows, outcome.column)
    if not np.isfinite(table).all():
        table = table[np.isfinite(table)][None]
    if not table.size:
        return Interval(np.nan, np.nan, np.nan)
    if outcome.share and np.isin(table, (0.0, 1.0)).all():
        return share_interval(table) if len(table) > 1 else wilson(table.sum(), table.size)
    if table.size == 1:
        return Interval(float(table.item()), np.nan, np.nan)
    mean = mean_interval(table)
    return Interval(mean.value, max(mean.low, 0.0), min(mean.high, 1.0)) if outcome.share else mean


def _table(rows: Sequence[Row], column: str) -> np.ndarray:
    """Return the means of a column by training seed and world seed."""
    training = sorted({row["training_seed"] or 0 for row in rows})
    worlds = sorted({row["world_seed"] for row in rows})
    cells: dict[tuple[int, int], list[float]] = {}
    for row in rows:
        if row[column] is not None:
            cells.setdefault((row["training_seed"] or 0, row["world_seed"]), []).append(float(row[column]))
    return np.array([[np.mean(cells[a, b]) if (a, b) in cells else np.nan for b in worlds] for a in training])


def _numbers(rows: Sequence[Row], outcome: Outcome) -> list[float]:
    return [float(row[outcome.column]) for row in rows if row[outcome.column] is not None]


def group(rows: Sequence[Row], of: Callable[[Row], Any]) -> dict[Any, list[Row]]:
    """Return rows by what a function says of them, in their order."""
    parts: dict[Any, list[Row]] = {}
    for row in rows:
        parts.setdefault(of(row), []).append(row)
    return parts
