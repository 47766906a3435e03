"""The sensor of light, temperature or pressure around the body."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Senses
from ecs_eco.nervous.sensors.sense import Seekers, Sense, nose
from ecs_eco.space.geometry import back_into

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def ambient(quantity: str, zero: float, scale: float, at: Sequence[float] = (), number: int = 0,
            dark: float | None = None) -> Sense:
    """Read light, temperature or pressure of the surroundings at a place of the body,
    as (value − zero)/scale.

    With `dark` the value is log10(1 + value/dark).
    """
    forward, left, up = (np.float32(v) for v in [*at, 0.0, 0.0, 0.0][:3])

    def sense(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        x, y, z = seekers.index.x, seekers.index.y, seekers.index.z
        own, space = number in table.species.own_places, world.space
        if own or forward or left or up:
            of = table[Senses] if own else None
            ahead, aside = (forward, left) if of is None else (of.forward[seekers.rows, number],
                                                               of.left[seekers.rows, number])
            x, y = nose(seekers, ahead, aside, space)
            z = back_into(z + seekers.radius * up, space.lengths[2], space.wrap[2]) if space.volume else z
        value = world.surroundings(quantity, x, y, z)
        if dark is not None:
            value = np.log10(np.float32(1) + value / np.float32(dark))
        out[:, column] = (value - np.float32(zero)) / np.float32(scale)

    return sense
