"""Component fields that a world records for individual organisms, listed in its key `record`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco._lazy import stored_name
from ecs_eco.engine.errors import listed, refusal

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

MOST_COLUMNS = 256  # maximum number of columns for all recorded fields together


class Fields:
    """Columns that follow the standard columns of births, deaths, snapshots and migrants: a scalar field has
    one column, such as "Strain.virulence"; an array field has a column for each element: "Strain.genome.0",
    "Strain.genome.1" and so on.

    Raises ConfigError if a field belongs to no species, or if there are too many columns.
    """

    def __init__(self, world: SpatialWorld, species: list[str]) -> None:
        self._tables = [world.tables[name] for name in species]
        self._columns: dict[str, tuple[str, int, np.dtype]] = {}  # field, index within it, type
        for i, field in enumerate(() if world.config is None else world.config.record):
            found = [values for table in self._tables if (values := values_of(table, field)) is not None]
            if not found:
                some = dict.fromkeys(c.__name__ for table in self._tables for c in table.columns)
                what = f"no species has the component {field.partition('.')[0]}"
                raise refusal(("record", i), what, field, listed(some, 40))
            size, dtype = max(map(_size, found)), np.result_type(*(values.dtype for values in found))
            single = all(len(values.shape) == 1 for values in found)
            names = [field] if single else [f"{field}.{place}" for place in range(size)]
            self._columns |= {name: (field, place, dtype) for place, name in enumerate(names)}
            if len(self._columns) > MOST_COLUMNS:
                raise refusal(("record", i), "too many columns", field, f"at most {MOST_COLUMNS} in all")
        self.names = tuple(self._columns)

    def of(self, table: Table, rows: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return the columns for rows i64[k] of a table; fields that it lacks are 0."""
        out = []
        for field, place, dtype in self._columns.values():
            values, column = values_of(table, field), np.zeros(rows.size, dtype)
            if values is not None and place < _size(values):
                column[:] = np.asarray(values[rows]).reshape(rows.size, -1)[:, place]
            out.append(column)
        return tuple(out)

    def missing(self, species: np.ndarray) -> dict[str, np.ndarray]:
        """Return, by column, which rows lack the field, bool[k], given the species of each row, i8[k]."""
        out = {}
        for name, (field, place, _) in self._columns.items():
            held = [values_of(table, field) for table in self._tables]
            out[name] = np.array([values is None or place >= _size(values) for values in held])[species]
        return out


def values_of(table: Table, field: str) -> np.ndarray | None:
    """Return a table's column for the field "Component.field"; None if the table has no such field."""
    component, _, name = field.partition(".")
    for part, columns in table.columns.items():
        if component in (part.__name__, stored_name(part)) and name in part.fields:
            values: np.ndarray = getattr(columns, name)
            return values
    return None


def _size(values: np.ndarray) -> int:
    return int(np.prod(values.shape[1:]))
