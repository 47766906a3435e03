"""Additional series columns: values of reporters, and energy gained from each food."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.config.checks.reporters import fault_of_name
from ecs_eco.config.formula import Formula, FormulaError
from ecs_eco.config.models.reporters import EATEN, is_reporter
from ecs_eco.config.reporter_formula import ReporterFormula, Scope, compile_reporter
from ecs_eco.engine.errors import listed, refusal, unknown_name
from ecs_eco.record.fields import values_of
from ecs_eco.record.parquet import read_parts

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld


class Reports:
    """The values of a world's reporters in each tick of a block, f64[ticks, species, reporters].

    A value for the whole world is repeated in each species' row; NaN means that a species has no value.
    """

    def __init__(self, world: SpatialWorld, names: list[str], block: int) -> None:
        self.names, self.place = list(world.reporters), {name: i for i, name in enumerate(names)}
        for name, what in world.reporters.items():
            _check_fields(world, name, what, names)
        self.latest: dict[str, float | dict[str, float]] = {}  # values in the last tick
        self.values = np.full((block, len(names), len(self.names)), np.nan)

    def note(self, world: SpatialWorld, at: int) -> None:
        """Evaluate all reporters for the tick that has just ended."""
        scope = Scope(world.tables)
        for i, (name, what) in enumerate(world.reporters.items()):
            said, row = said_by(world, name, what, self.place, scope), self.values[at, :, i]
            self.latest[name] = said
            if isinstance(said, dict):
                row[:] = np.nan
                for species, number in said.items():
                    row[self.place[species]] = number
            else:
                row[:] = said

    def columns(self, n: int) -> dict[str, np.ndarray]:
        """Return copies of the first n ticks as flat columns, sorted by tick, then species."""
        return {name: self.values[:n, :, i].flatten() for i, name in enumerate(self.names)}


class Intake:
    """The energy that each species gained from each food, in each tick of a block: f64[ticks, species, foods].

    It is part of the energy taken in; the rest comes from light, parents or reactions. `total` is its sum over
    all ticks; `flows`, f64[species, columns], is the sum of the ledger, written by `add_up`. A recording that
    continues from a checkpoint starts with both at 0.
    """

    def __init__(self, world: SpatialWorld, names: list[str], block: int, columns: int) -> None:
        tables = [world.tables[name] for name in names]
        self.foods = list(dict.fromkeys(food.eats for table in tables for food in table.species.foods))
        self._places = [
            (s, self.foods.index(food.eats), food.eats, table)
            for s, table in enumerate(tables)
            for food in table.species.foods
        ]
        self.eaters = {s for s, *_ in self._places}
        self.values = np.zeros((block, len(names), len(self.foods)))
        self.total = np.zeros((len(names), len(self.foods)))
        self.flows = np.zeros((len(names), columns))

    def gained(self, at: int) -> np.ndarray:
        """Return the energy gained in the tick that has just ended, f64[species, foods], and store it."""
        row = self.values[at]
        for s, k, food, table in self._places:
            row[s, k] = table.species.eaten.get(food, 0.0)
        return row

    def columns(self, n: int) -> dict[str, np.ndarray]:
        """Return copies of the first n ticks as flat columns, sorted by tick, then species."""
        return {EATEN + food: self.values[:n, :, k].flatten() for k, food in enumerate(self.foods)}


def said_by(
    world: SpatialWorld, name: str, what: Any, species: Mapping[str, int], scope: Scope | None = None
) -> float | dict[str, float]:
    """Return the current value of a reporter: a number for the world, or numbers by species; None becomes NaN.

    Raises ValueError for anything else; an error within a function names the reporter.
    """
    if isinstance(what, ReporterFormula):
        return what(Scope(world.tables) if scope is None else scope, species)
    try:
        said = what(world)
    except Exception as error:
        error.add_note(f"in the reporter {name!r}, at tick {world.tick}")
        raise
    if not isinstance(said, Mapping):
        return _number(name, said)
    if unknown := [s for s in said if s not in species]:
        raise ValueError(unknown_name(f"reporter {name!r}", "species", unknown[0], species))
    return {s: _number(f"{name}, {s}", x) for s, x in said.items()}


def value_of(world: SpatialWorld, rule: Formula) -> float:
    """Return the value of a stop rule's formula after the last tick.

    Raises ValueError if it reads a reporter of each species as one of the world, or the reverse.
    """
    names = world.species_names()
    values: dict[str, Any] = {name: table.n for name, table in world.tables.items()}
    for name, what in world.reporters.items():
        if any(used == name or used.startswith(f"{name}_") for used in rule.names):
            latest = world.recorder.reports.latest if world.recorder and world.recorder.reports else {}
            said = latest[name] if name in latest else said_by(world, name, what, dict.fromkeys(names, 0))
            own = (
                {f"{name}_{s}": said.get(s, np.nan) for s in names}
                if isinstance(said, dict)
                else {name: said}
            )
            values = own | values
    if missing := sorted(rule.names - values.keys()):
        raise ValueError(unknown_name(f"until = {rule.text!r}", "number", missing[0], values))
    return float(rule({name: values[name] for name in rule.names}).item())


def past_values(world: SpatialWorld, series: Path, rule: Formula) -> list[float]:
    """Return the values of a stop rule's formula after each tick of a world's recorded series."""
    table, names = read_parts(series, ["n", *world.reporters]), world.species_names()
    columns = {name: np.reshape(table[name], (-1, len(names))) for name in table.column_names}
    values = dict(zip(names, columns.pop("n").T, strict=True))
    for name, column in columns.items():
        values |= {name: column[:, 0]} | {f"{name}_{s}": column[:, i] for i, s in enumerate(names)}
    return list(rule({name: values[name] for name in rule.names}).tolist())


def _number(name: str, said: Any) -> float:
    if said is None:
        return float("nan")
    if isinstance(said, np.ndarray | np.generic) and said.ndim == 0:
        said = said.item()
    if not isinstance(said, Real):
        raise ValueError(
            f"reporter {name!r} returned {said!r:.60}; expected a number or a dict: species → number"
        )
    return float(said)


def add_reporter(world: SpatialWorld, name: str, what: Any) -> None:
    """Add a measurement to a world; see `World.add_reporter`."""
    if fault := fault_of_name(name, world.tables) or ("already exists" if name in world.reporters else ""):
        raise ValueError(f"reporter {name!r}: {fault}")
    recorder = world.recorder
    if recorder is not None and recorder.sink is not None:
        raise RuntimeError(
            f"reporter {name!r}: this world is already being recorded to a folder; add it to "
            f'the world file: reporters = {{ "{name}" = … }}'
        )
    if isinstance(what, str):
        what = _compiled(world, name, what)
    elif not callable(what):
        raise ValueError(f"reporter {name!r}: {what!r:.60} is neither a formula nor a function of the world")
    _check_fields(world, name, what, [n for n, t in world.tables.items() if not t.species.is_object])
    world.reporters[name] = what
    if recorder is not None:
        recorder.flush()
        recorder.reports = Reports(world, recorder.names, recorder.block)


def _compiled(world: SpatialWorld, name: str, text: str) -> ReporterFormula:
    """Return a formula over the components of the existing tables."""
    fields = {c.__name__: c.fields for table in world.tables.values() for c in table.columns}
    try:
        return compile_reporter(text, world.tables, fields)
    except FormulaError as error:
        raise refusal(("reporters", name), error.what, text, error.allowed, error.nearest) from None


def _check_fields(world: SpatialWorld, name: str, what: Any, species: list[str]) -> None:
    """Raise ConfigError before the first tick if no species has the fields that a formula reads."""
    for of, component, field in sorted(getattr(what, "fields", ()), key=str):
        among = species if of is None else [of]
        if all(values_of(world.tables[s], f"{component}.{field}") is None for s in among):
            some = (c.__name__ for s in among for c in world.tables[s].columns)
            fault = (f"{of} does not have" if of else "no species has") + f" the component {component}"
            raise refusal(("reporters", name), fault, what.text, listed(dict.fromkeys(some), 40))


def absent(column: str, n: int) -> np.ndarray:
    """Return n values that fill a column of the series for ticks without values."""
    if column.startswith(EATEN):
        return np.zeros(n)
    return np.full(n, np.nan) if is_reporter(column) else np.zeros(n, np.int32)
