"""The sensor for light, temperature or pressure around the body."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.nervous.sensors.sense import Sense, of_sensor, place_of
from ecs_eco.space.seekers import Seekers

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def ambient(
    quantity: str,
    zero: float,
    scale: float,
    at: Sequence[float] = (),
    number: int = 0,
    dark: float | None = None,
) -> Sense:
    """Read the ambient light, temperature or pressure at a point on the body, as (value − zero)/scale.

    With `dark`, the value is log10(1 + value/dark).
    """
    shared = np.float32(zero), np.float32(scale)

    def read(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        base, unit = shared
        if table.species.traits:
            base, unit = of_sensor(table, seekers, number, zero=base, scale=unit)
        if dark is None and world.environment.get(quantity) is None:  # the same everywhere
            out.T[column] = (np.float32(world.ambient[quantity]) - base) / unit
            return
        x, y, z = place_of(table, seekers, number, at, world.space)
        value = world.surroundings(quantity, x, y, z)
        if dark is not None:
            threshold = of_sensor(table, seekers, number, dark=np.float32(dark))[0]
            value = arrays.log10(np.float32(1) + value / threshold)
        out[:, column] = (value - base) / unit

    return Sense(read, divisible=False)
