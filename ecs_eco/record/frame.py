"""The Arrow table of `world.series()`, for notebooks, pandas and polars, and its blocks of rows in memory."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco._html import grid
from ecs_eco._lazy import Later
from ecs_eco.record.reports import absent

if TYPE_CHECKING:
    import pyarrow as pa

    from ecs_eco.record import parquet
else:
    parquet = Later("ecs_eco.record.parquet")

Block = Mapping[str, np.ndarray]
ENDS = 4  # rows shown at the start and at the end


class SeriesTable:
    """A pyarrow.Table of series, with methods for pandas and polars.

    It has all the methods of pyarrow.Table. Pass `series.arrow` to pyarrow functions, for example to write
    files; pass the series itself to polars, pandas and DuckDB.

    Attributes
    ----------
    arrow : pyarrow.Table

    Examples
    --------
    >>> from ecs_eco import World
    >>> series = World.from_config("predator-prey", seed=1).run(3).series()
    >>> series.num_rows, len(series.to_pandas()), series.to_polars().height
    (9, 9, 9)
    """

    def __init__(self, arrow: Any) -> None:
        self.arrow = arrow

    def to_pandas(self, **options: Any) -> Any:
        """Return a pandas.DataFrame.

        Parameters
        ----------
        **options
            Passed to `pyarrow.Table.to_pandas`.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        ModuleNotFoundError
            If pandas is not installed.
        """
        _needed("pandas")
        return self.arrow.to_pandas(**options)

    def to_polars(self) -> Any:
        """Return a polars.DataFrame.

        Returns
        -------
        polars.DataFrame

        Raises
        ------
        ModuleNotFoundError
            If polars is not installed.
        """
        return _needed("polars").from_arrow(self.arrow)

    def wide(self, *columns: str) -> SeriesTable:
        """Return a table with one row per tick and one column per species.

        Parameters
        ----------
        *columns : str
            Columns of the series; default: "n". If there are several, the result has columns such as "n deer".

        Returns
        -------
        SeriesTable
            Missing values are NaN.

        Raises
        ------
        KeyError
            If the series has no such numeric column.

        Examples
        --------
        >>> from ecs_eco import World
        >>> World.from_config("predator-prey", seed=1).run(3).series().wide().column_names
        ['tick', 'grass', 'deer', 'wolf']
        """
        import pyarrow as pa

        wanted = columns or ("n",)
        for name in wanted:
            if name not in self.arrow.column_names or name in ("tick", "species"):
                raise KeyError(
                    f"the series has no numeric column {name!r}: it has {', '.join(self.arrow.column_names[2:])}"
                )
        ticks, row = np.unique(self.arrow["tick"].to_numpy(), return_inverse=True)
        each = np.array(self.arrow["species"].to_pylist(), object)
        out: dict[str, Any] = {"tick": ticks}
        for name in wanted:
            values = self.arrow[name].to_numpy()
            for species in dict.fromkeys(each):
                column = np.full(ticks.size, np.nan)
                column[row[each == species]] = values[each == species]
                if np.issubdtype(values.dtype, np.integer) and not np.isnan(column).any():
                    column = column.astype(values.dtype)
                out[species if len(wanted) == 1 else f"{name} {species}"] = column
        return SeriesTable(pa.table(out))

    def _repr_html_(self) -> str:
        n = self.arrow.num_rows
        rows = list(range(n)) if n <= 2 * ENDS else [*range(ENDS), *range(n - ENDS, n)]
        columns = [self.arrow[name].take(rows).to_pylist() for name in self.arrow.column_names]
        body: list[tuple[Any, ...]] = list(zip(*columns, strict=True))
        if n > 2 * ENDS:
            body.insert(ENDS, ("…",) * len(columns))
        return grid(
            self.arrow.column_names, body, f"Series: {n:,} rows", ".to_pandas(), .to_polars(), .wide()"
        )

    def __repr__(self) -> str:
        return repr(self.arrow)

    def __len__(self) -> int:
        return int(self.arrow.num_rows)

    def __getitem__(self, key: Any) -> Any:
        return self.arrow[key]

    def __eq__(self, other: object) -> bool:
        return bool(self.arrow == _arrow(other))

    __hash__ = None  # type: ignore[assignment]  # like pyarrow.Table

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        return self.arrow.__arrow_c_stream__(requested_schema)

    def __reduce__(self) -> tuple[Any, ...]:
        return SeriesTable, (self.arrow,)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *dir(self.arrow)})

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name == "arrow":
            raise AttributeError(name)
        value = getattr(self.arrow, name)
        return _wrapping(value) if callable(value) else value


def _arrow(value: Any) -> Any:
    return value.arrow if isinstance(value, SeriesTable) else value


def _wrapping(method: Callable[..., Any]) -> Callable[..., Any]:
    """Return a pyarrow.Table method that accepts series, and returns series instead of tables."""

    @wraps(method)
    def call(*args: Any, **options: Any) -> Any:
        import pyarrow as pa

        value = method(*map(_arrow, args), **{key: _arrow(option) for key, option in options.items()})
        return SeriesTable(value) if isinstance(value, pa.Table) else value

    return call


def _needed(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        raise ModuleNotFoundError(
            f'{module} is not installed: pip install -e ".[notebook]" in the source folder', name=module
        ) from None


def joined(blocks: Sequence[Block], prefix: str = "") -> dict[str, np.ndarray]:
    """Return the concatenated columns of blocks, with a prefix; missing columns are filled with `absent`."""
    names = dict.fromkeys(name for block in blocks for name in block)
    return {
        prefix + name: np.concatenate([b.get(name, absent(name, b["tick"].size)) for b in blocks])
        for name in names
    }


def as_table(blocks: Sequence[Block], words: Mapping[str, Sequence[str]]) -> pa.Table:
    """Return blocks as one pyarrow.Table; `words` is the same as for `ecs_eco.record.parquet.to_arrow`."""
    columns = joined(blocks)
    return parquet.to_arrow(columns, {name: known for name, known in words.items() if name in columns})


def under(state: Mapping[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    """Return the arrays of a state whose names begin with a prefix, with the prefix removed."""
    return {key.removeprefix(prefix): array for key, array in state.items() if key.startswith(prefix)}
