"""Measurements: external series from CSV files with evenly spaced times, and checks of the [data] section."""

import csv
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import no_such
from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest
from ecs_eco.engine.files import read_bytes

FEWEST = 12
"""Minimum number of samples in a measured series."""
MOST_BYTES = 20_000_000
MOST_ROWS = 1000


class Place(NamedTuple):
    """The origin of an external series, for messages: keys and their sources."""

    file: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    of_file: str = "--against"
    of_columns: str = "--match"


IN_WORLD = Place(("data", "file"), ("data", "columns"), "", "")


class Outside(NamedTuple):
    """An external series: evenly spaced times f64[n], and columns f64[n], keyed by the species or reporter with
    which they are compared; `named` gives their names in the file."""

    times: np.ndarray
    columns: dict[str, np.ndarray]
    named: dict[str, str]
    unit: str  # name of its time column
    ticks: float | None = None  # ticks of a run per unit of time, if known

    @property
    def step(self) -> float:
        """Time between samples."""
        return float(self.times[1] - self.times[0])


def outside_of(data: Mapping[str, Any], folder: Path, names: Sequence[str], source: str = "") -> Outside:
    """Read the external series in [data] for the species and reporters in `names`. Raises ConfigError."""
    place = IN_WORLD._replace(of_file=source, of_columns=source)
    read = read_outside(folder / data["file"], names, data.get("columns"), place, data.get("time"))
    return read._replace(unit=data.get("unit") or read.unit, ticks=data.get("ticks"))


def measured(config: WorldConfig, source: str = "") -> Outside | None:
    """Read the external series of a world if it has one. Raises ConfigError, located at `source`."""
    data = config.data
    if data is None or not ((config.folder / config._source).is_file() or config.file(data.file).is_file()):
        return None
    return outside_of(data.model_dump(), config.folder, [*config.species, *config.reporters], source)


def read_outside(
    file: str | Path,
    names: Sequence[str],
    match: Mapping[str, str] | None = None,
    place: Place | None = None,
    time: str | None = None,
) -> Outside:
    """Read a CSV file with times in the `time` column, by default the first; `match` maps columns to the
    species or reporters in `names` that they are compared with. Leading and trailing rows without numbers are
    left out. Raises ConfigError."""
    place = place or Place()
    head, rows = _rows(Path(file), place)
    if time is not None and time not in head:
        fault, allowed = "no column with this name", listed(head)
        raise ConfigError(
            [Problem((*place.file[:-1], "time"), fault, time, allowed, nearest(time, head), place.of_file)]
        )
    time = time or head[0]
    named = _named(file, [name for name in head if name != time], names, match or {}, place)
    table = np.array([[_number(row[head.index(name)]) for name in (time, *named)] for row in rows], float)
    table = table.reshape(-1, 1 + len(named))
    whole = np.flatnonzero(np.isfinite(table).all(1))
    table = table[whole[0] : whole[-1] + 1] if whole.size else table[:0]
    steps = np.diff(table[:, 0])
    even = not steps.size or ((steps > 0).all() and np.ptp(steps) <= 0.02 * steps.mean())
    faults = (
        (
            not FEWEST <= len(table) <= MOST_ROWS or not np.isfinite(table).all(),
            f"has {len(whole):,} rows of numbers, or gaps between them",
            f"{FEWEST} to {MOST_ROWS:,} rows without gaps",
        ),
        (not even, f"its times ({time}) are not evenly spaced", "times that increase by a constant step"),
        ((table[:, 1:] < 0).any(), "has numbers below 0", "counts or densities"),
        (not table[:, 1:].any(0).all(), "has a column with only zeros", "counts or densities"),
    )
    for wrong, fault, allowed in faults:
        if wrong:
            raise _refused(place, fault, file, allowed)
    columns = {name: table[:, 1 + k] for k, name in enumerate(named.values())}
    return Outside(table[:, 0], columns, {v: k for k, v in named.items()}, time)


def _named(
    file: str | Path, head: list[str], names: Sequence[str], match: Mapping[str, str], place: Place
) -> dict[str, str]:
    """Return the columns used, and the species or reporter that each is compared with."""
    named = {name: name for name in head if name in names}
    for column, name in match.items():
        for what, value, known in (("column", column, head), ("species or reporter", name, names)):
            if value not in known:
                raise ConfigError(
                    [
                        Problem(
                            (*place.columns, *(place.columns and (column,))),
                            f"no {what} with this name",
                            value,
                            listed(known),
                            nearest(value, known),
                            place.of_columns,
                        )
                    ]
                )
        named = {k: v for k, v in named.items() if v != name} | {column: name}
    if not named:
        how = '[data] columns = { COLUMN = "SPECIES" }' if place.columns else "--match COLUMN=SPECIES"
        allowed = f"{how}, with a column ({listed(head)}) and a species or reporter ({listed(names)})"
        raise _refused(place, "no column has the name of a species or reporter", file, allowed)
    return named


def _rows(file: Path, place: Place) -> tuple[list[str], list[list[str]]]:
    try:
        text = read_bytes(file, MOST_BYTES).decode("utf-8-sig")
        rows = [row for row in csv.reader(text.splitlines()) if any(row)]
    except (OSError, ValueError, csv.Error) as error:
        fault = f"cannot be read: {getattr(error, 'strerror', None) or error}"
        raise _refused(place, fault, file, "a CSV file with a header") from None
    if not rows or len(rows[0]) < 2:
        raise _refused(place, "has no header with at least two columns", file, "time, then numbers")
    head = [name.strip() for name in rows[0]]
    if short := next((i for i, row in enumerate(rows[1:], 2) if len(row) != len(head)), None):
        raise _refused(
            place, f"row {short} does not have as many columns as the header", file, f"{len(head)} columns"
        )
    return head, rows[1:]


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _refused(place: Place, what: str, file: str | Path, allowed: str) -> ConfigError:
    return ConfigError([Problem(place.file, what, str(file), allowed, source=place.of_file)])


def check_measurements(config: WorldConfig) -> Iterator[Problem]:
    """Yield the problems with the file named in [data]."""
    try:
        measured(config)
    except ConfigError as error:
        yield from error.problems


def check_data(config: WorldConfig) -> Iterator[Problem]:
    """Yield the problems with names in [data]."""
    if config.data is None:
        return
    known, taken = [*config.species, *config.reporters], set()
    for column, name in config.data.columns.items():
        key = ("data", "columns", column)
        if name not in known:
            yield no_such(key, "species or reporter", name, known)
        elif name in taken:
            fault = "another column is also compared with it"
            yield Problem(key, fault, name, "one column per species or reporter")
        taken.add(name)
