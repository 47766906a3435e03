"""Read a run's per-tick series as arrays of shape (ticks, species)."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from ecs_eco.config.models.reporters import is_reporter
from ecs_eco.record import belonging, seal
from ecs_eco.record.parquet import each_batch, read_part, to_codes, to_numpy

DIED = "died: "
"""Prefix of the series columns that count deaths by cause."""


@dataclass(frozen=True)
class Series:
    """The series of one run, with a value for each tick and species.

    Attributes
    ----------
    ticks : array of int64, shape (ticks,)
    species : tuple of str
    columns : dict of str to array of float64, shape (ticks, species)
        "n", "births", "deaths", "energy" and more; "died: CAUSE" counts the deaths from a cause.
    manifest : dict
        Manifest of the run folder; empty for a table.

    Examples
    --------
    >>> from ecs_eco.analysis.runs import load_series
    >>> series = load_series({"hare": [10, 12, 9], "lynx": [3, 3, 0]})
    >>> series.n.shape, series.persisted, series.index("lynx")
    ((3, 2), False, 1)
    """

    ticks: np.ndarray
    species: tuple[str, ...]
    columns: dict[str, np.ndarray]
    manifest: dict[str, Any] = field(default_factory=dict)

    @property
    def n(self) -> np.ndarray:
        """Number of organisms, (ticks, species)."""
        return self.columns["n"]

    @property
    def causes(self) -> tuple[str, ...]:
        """The causes of death that have a column."""
        return tuple(name[len(DIED) :] for name in self.columns if name.startswith(DIED))

    @property
    def reporters(self) -> tuple[str, ...]:
        """The columns filled by custom reporters."""
        return tuple(name for name in self.columns if is_reporter(name))

    @property
    def length(self) -> int:
        """Number of ticks, from the beginning of the first to the end of the last."""
        return int(self.ticks[-1] - self.ticks[0]) + 1 if len(self.ticks) else 0

    @property
    def dt(self) -> float:
        """Length of a tick [s]."""
        return float(self.manifest.get("dt", 1.0))

    def index(self, species: str) -> int:
        """Return the column index of a species.

        Parameters
        ----------
        species : str

        Returns
        -------
        int

        Raises
        ------
        KeyError
            If the species is unknown.
        """
        if species not in self.species:
            near = get_close_matches(species, self.species, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise KeyError(
                f"no species {species!r} in this run; expected one of {', '.join(self.species)}{hint}"
            )
        return self.species.index(species)

    def of(self, species: str, column: str = "n") -> np.ndarray:
        """Return one column of one species.

        Parameters
        ----------
        species : str
        column : str, default "n"

        Returns
        -------
        array of float64, shape (ticks,)

        Raises
        ------
        KeyError
            If the species or column is unknown.

        Examples
        --------
        >>> from ecs_eco.analysis.runs import load_series
        >>> load_series({"hare": [10, 12, 9]}).of("hare").tolist()
        [10.0, 12.0, 9.0]
        """
        return self.columns[column][:, self.index(species)]

    @cached_property
    def extinct(self) -> np.ndarray:
        """Tick of each species' extinction, NaN if it is alive at the end, (species,)."""
        when = np.full(len(self.species), np.nan)
        for j, n in enumerate(self.n.T):
            if len(n) and n[-1] == 0:
                lived = np.flatnonzero(n)
                when[j] = self.ticks[lived[-1] + 1] if len(lived) else self.ticks[0]
        return when

    @property
    def present(self) -> np.ndarray:
        """True for each species that ever had a member, even if it died in the first tick, (species,) bool."""
        died = self.columns.get("deaths", np.zeros_like(self.n))
        return np.asarray(((self.n > 0) | (died > 0)).any(axis=0))

    @property
    def there(self) -> list[str]:
        """Names of the species that are `present`."""
        return [s for s, here in zip(self.species, self.present, strict=True) if here]

    @property
    def persisted(self) -> bool:
        """True if every species that was ever present is alive at the end."""
        return bool(np.isnan(self.extinct[self.present]).all())


def mean_of_there(values: np.ndarray, axis: int = 0) -> np.ndarray:
    """Return the mean along an axis, ignoring missing values; NaN where all are missing."""
    return np.asarray(np.ma.masked_invalid(values).mean(axis).filled(np.nan))


def read_manifest(run: Path | str) -> dict[str, Any]:
    """Return a run folder's manifest; raise FileNotFoundError if there is none, RecordingError if it is damaged."""
    return seal.read_manifest(Path(run))


def parts(run: Path | str, kind: str) -> list[Path]:
    """Return a run folder's Parquet files of one kind (series, births, deaths, snapshots), in order. Raises
    RecordingError if files are missing, ForeignFile if a file belongs to another run."""
    there = (Path(run) / "manifest.json").is_file()
    return belonging.parts(Path(run), kind, seal.read_manifest(Path(run)) if there else {})


def tables(
    run: Path | str, kind: str, columns: Sequence[str] | None = None, batches: bool = False
) -> Iterator[pa.Table]:
    """Yield the tables of one kind, with these columns or all, a file or (`batches`) a part of a file at a time.
    Dictionary columns become strings, because they differ between files. Raises errors as `parts` does, and
    RecordingError if a file is damaged."""
    sealed, text = seal.has_seals(Path(run)), pa.string()
    for file in parts(run, kind):
        for table in each_batch(file, columns, sealed) if batches else [read_part(file, columns, sealed)]:
            kinds = [
                field.with_type(text) if pa.types.is_dictionary(field.type) else field
                for field in table.schema
            ]
            yield table.cast(pa.schema(kinds, table.schema.metadata))


def whole_table(run: Path | str, kind: str, columns: Sequence[str] | None = None) -> pa.Table:
    """Return all rows of one kind, without columns if there are no files. Columns that a file lacks, such as
    causes before their first death, are null in its rows. Raises errors as `tables` does."""
    found = list(tables(run, kind, columns))
    return pa.concat_tables(found, promote_options="permissive") if found else pa.table({})


def load_series(
    run: Series | pa.Table | Mapping[str, Any] | Path | str, species: Sequence[str] | None = None
) -> Series:
    """Return the series of a recorded run.

    Parameters
    ----------
    run : str, Path, pyarrow.Table, SeriesTable, Mapping or Series
        A run folder, a table as returned by `World.series`, or population sizes by species.
    species : sequence of str, optional
        Species to select, in this order, producers first; default: all.

    Returns
    -------
    Series

    Raises
    ------
    FileNotFoundError
        If the folder contains no series.
    RecordingError
        If a file is damaged.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.analysis.runs import load_series
    >>> world = World.from_config("predator-prey", seed=1).run(3)
    >>> load_series(world.series(), ["deer", "wolf"]).n.shape
    (3, 2)
    """
    run = getattr(run, "arrow", run)  # the table that world.series() returns wraps an Arrow table
    if isinstance(run, Series):
        series = run
    elif isinstance(run, Mapping):
        numbers = np.column_stack([np.asarray(v, float) for v in run.values()])
        series = Series(np.arange(len(numbers)), tuple(run), {"n": numbers})
    elif isinstance(run, pa.Table):
        series = _pivot(run, {})
    else:
        manifest, table = read_manifest(run), whole_table(run, "series")
        if not table.column_names:
            raise FileNotFoundError(f"{run} contains no series: expected series/part-00000.parquet")
        series = _pivot(table, manifest)
    if species is None or tuple(species) == series.species:
        return series
    order = [series.index(name) for name in species]
    columns = {name: values[:, order] for name, values in series.columns.items()}
    return Series(series.ticks, tuple(species), columns, series.manifest)


def pivot(
    table: pa.Table, *keys: str, first: Sequence[str] = ()
) -> tuple[np.ndarray, list[tuple[str, ...]], dict[str, np.ndarray]]:
    """Return the ticks of a table, the words of each key column (with `first` before the first key's others),
    and all other columns as f64[ticks, words of each key, …], with 0 for combinations without a row."""
    ticks, row = np.unique(to_numpy(table["tick"]), return_inverse=True)
    place, words = [row], []
    for key in keys:
        seen, which = to_codes(table[key])
        words.append(tuple(dict.fromkeys([*first, *seen] if key == keys[0] else seen)))
        place.append(np.array([words[-1].index(word) for word in seen], np.int64)[which])
    columns = {}
    for name in table.column_names:
        if name not in ("tick", *keys):
            columns[name] = np.zeros((len(ticks), *map(len, words)))
            columns[name][tuple(place)] = to_numpy(table[name])
    return ticks, words, columns


def _pivot(table: pa.Table, manifest: dict[str, Any]) -> Series:
    for name in ("tick", "species", "n"):
        if name not in table.column_names:
            raise ValueError(f"the series has no column {name!r}: it has {', '.join(table.column_names)}")
    ticks, (species,), columns = pivot(table, "species", first=manifest.get("species", ()))
    return Series(ticks, species, columns, manifest)
