"""The component Sensor of a species: columns computed on access from the results of `Sense`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from ecs_eco.components import Senses
from ecs_eco.config.models.sensors import Sensor, Touch
from ecs_eco.engine.schema import Columns
from ecs_eco.engine.uids import matched

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

FIELDS = ("readings", "radius", "forward", "left")


class Readings(Columns):
    """The columns of Sensor in one table; they are not saved and affect nothing.

    The columns f32[capacity, …] are computed from `nerves.sensed` on access, and are read-only.
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
        raise TypeError(f"Sensor.{name} is read-only; `Sense` fills it")

    def _readings(self) -> np.ndarray:
        """Return the readings of all rows, f32[capacity, channels]: NaN for organisms that have not
        sensed."""
        table, column = self._table, self._column
        uid, x = sensed = table.species.nerves.sensed
        if self._made_of is not sensed or self._version != table.version or len(column) != table.capacity:
            column = np.full((table.capacity, len(table.species.nerves.channels)), np.nan, np.float32)
            rows, order = table.rows(), np.argsort(uid, kind="stable")
            at, known = matched(uid[order], table.uid[rows])
            if known.any():
                column[rows[known]] = x[order[at[known]]]
            column.flags.writeable = False
            object.__setattr__(self, "_made_of", sensed)
            object.__setattr__(self, "_column", column)
            object.__setattr__(self, "_version", table.version)
        return column

    def _own(self, name: str) -> np.ndarray:
        """Return a field of the sensors, whether individual or shared by the species: f32[capacity, sensors]."""
        table = self._table
        if Senses in table.columns:
            return np.asarray(table.field(Senses, name))
        values = [_of_species(sensor, name) for sensor in table.species.sensors]
        return np.broadcast_to(np.array(values, np.float32), (table.capacity, len(values)))


def _of_species(sensor: Sensor, name: str) -> float:
    """Return a species' value for a field of one of its sensors; 0 if the sensor lacks it."""
    if name == "radius":
        return float(getattr(sensor, "range", None) or 0.0)
    at = None if isinstance(sensor, Touch) else getattr(sensor, "at", None)
    return 0.0 if at is None else float(at[("forward", "left").index(name)])
