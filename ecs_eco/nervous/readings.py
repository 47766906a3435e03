"""The component Sensor of a species: columns that are made of what `Sense` has left, when somebody looks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from ecs_eco.components import Senses
from ecs_eco.config.models.sensors import Sensor, Touch
from ecs_eco.engine.schema import Columns

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

FIELDS = ("readings", "radius", "forward", "left")


class Readings(Columns):
    """Stands for the columns of Sensor in one table; nothing of it is saved, and none of it decides anything.

    The columns f32[capacity, …] are made of `nerves.sensed` when they are read, and can only be read.
    """

    __slots__ = ("_column", "_made_of", "_table", "_version")

    def __init__(self, table: Table) -> None:
        for name, value in {"_table": table, "_column": None, "_made_of": None, "_version": -1}.items():
            object.__setattr__(self, name, value)

    def __getattr__(self, name: str) -> Any:
        if name == "readings":
            return self._readings()
        if name in FIELDS:
            return self._own(name)
        raise AttributeError(f"Sensor has no field {name!r}; its fields are {', '.join(FIELDS)}")

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise TypeError(f"Sensor.{name} is read, not written; `Sense` fills it")

    def _readings(self) -> np.ndarray:
        """Return the readings of all rows, f32[capacity, channels]: NaN in those whose owner has not sensed."""
        table, column = self._table, self._column
        uid, x = sensed = table.species.nerves.sensed
        if self._made_of is not sensed or self._version != table.version or len(column) != table.capacity:
            column = np.full((table.capacity, len(table.species.nerves.channels)), np.nan, np.float32)
            rows, order = table.rows(), np.argsort(uid, kind="stable")
            if rows.size and order.size:
                at = order[np.searchsorted(uid, table.uid[rows], sorter=order).clip(max=order.size - 1)]
                known = uid[at] == table.uid[rows]
                column[rows[known]] = x[at[known]]
            column.flags.writeable = False
            object.__setattr__(self, "_made_of", sensed)
            object.__setattr__(self, "_column", column)
            object.__setattr__(self, "_version", table.version)
        return column

    def _own(self, name: str) -> np.ndarray:
        """Return one of the organisms' own values, or the species' for all: f32[capacity, sensors]."""
        table = self._table
        if Senses in table.columns:
            return np.asarray(table.field(Senses, name))
        values = [_of_species(sensor, name) for sensor in table.species.sensors]
        return np.broadcast_to(np.array(values, np.float32), (table.capacity, len(values)))


def _of_species(sensor: Sensor, name: str) -> float:
    """Return what a species says of one of its sensors; 0 where it says nothing."""
    if name == "radius":
        return float(getattr(sensor, "range", None) or 0.0)
    at = None if isinstance(sensor, Touch) else getattr(sensor, "at", None)
    return 0.0 if at is None else float(at[("forward", "left").index(name)])
