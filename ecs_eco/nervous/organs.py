"""Sensors and actions that some organisms lack because of their genes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Motor, Nervous, Traits

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


def blind(table: Table, rows: np.ndarray, x: np.ndarray) -> None:
    """Set the channels of sensors that organisms lack to 0: x f32[n, channels] of rows i64[n]."""
    places, column = _places(table.species.traits, "sensors."), 0
    senses = table.species.nerves.senses if places else ()
    for sensor, (_, width) in zip(table.species.sensors, senses, strict=False):
        if (at := places.get(sensor.name)) is not None:
            x[table[Traits].value[rows, at] < 0.5, column : column + width] = 0
        column += width


def disable(table: Table, rows: np.ndarray) -> None:
    """Suppress the actions that rows i64[n] lack; a continuous action gets its resting value."""
    places = _places(table.species.traits, "actions.")
    nerves = table.species.nerves
    for column, (group, action) in enumerate(nerves.actions if places else ()):
        if (at := places.get(f"{group}.{action}")) is None:
            continue
        lacking = rows[table[Traits].value[rows, at] < 0.5]
        table[Nervous].decision[lacking, column] = 0
        if group in nerves.ranges.groups:
            k = nerves.ranges.groups.index(group)
            table[Motor].command[lacking, k] = nerves.ranges.of(table, lacking).rest[..., k]


def _places(traits: Mapping[str, int], section: str) -> dict[str, int]:
    """Return the positions in Traits of a section's switches, by the name of the sensor or action that each
    one switches."""
    return {
        key.removeprefix(section).removesuffix(".present"): at
        for key, at in traits.items()
        if key.startswith(section) and key.endswith(".present")
    }
