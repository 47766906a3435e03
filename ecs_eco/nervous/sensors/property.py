"""The sensor for a property of nearby bodies: heat, light, electric current, a substance, age."""

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import of_row
from ecs_eco.components import Body
from ecs_eco.nervous.sensors.kin import add_kin
from ecs_eco.nervous.sensors.own import own_column
from ecs_eco.nervous.sensors.sense import Sense, of_sensor, own_range, place_of
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.sums import DECAYS, add_near

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def feel_property(
    property: str,
    of: list[str],
    radius: float,
    decay: str,
    report: str,
    zero: float,
    scale: float,
    at: list[float],
    substances: list[str],
    number: int = 0,
    kin: str | None = None,
) -> Sense:
    """Feel a property of bodies of some kinds around a point on the organism's own body, which is excluded.
    The reading is Σ weight × (value − zero)/scale or, as a mean, this sum divided by Σ weight; it is 0 if
    there are no bodies.

    A body is included if its center is nearer than `radius` [m]. Its weight at distance d is 1 with decay
    "none", 1 − d/radius with "linear", and 1/d² [1/m²] with "inverse_square", where d is at least its own
    radius. With `kin`, only relatives are included.
    """

    def read(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        _, own = own_range(table, seekers, number, radius)
        place = place_of(table, seekers, number, at, world.space)
        total, weight = np.zeros(seekers.n), np.zeros(seekers.n)
        base, unit = of_sensor(table, seekers, number, zero=np.float32(zero), scale=scale)
        differs = isinstance(base, np.ndarray)  # individual zeros are subtracted from the sum
        least = np.float32(0) if differs else base
        for other in (world.tables[name] for name in of):
            targets = world.index(other)
            value = own_column(other, property, substances)[targets.rows]
            value = value.astype(np.float32, copy=False) - least
            size = other[Body].radius[targets.rows]
            if kin is not None:
                add_kin(
                    seekers,
                    table,
                    other,
                    targets,
                    kin,
                    place,
                    own,
                    value.astype(np.float32),
                    size,
                    DECAYS[decay],
                    total,
                    weight,
                    world.split,
                )
            else:
                add_near(
                    seekers.index, place, own, targets, value, size, DECAYS[decay], total, weight, world.split
                )
        if differs:
            total -= weight * base
        world.split(_write, seekers.n, total, weight, report == "mean", 1.0 / unit, out.T, column)

    return Sense(read)


@njit
def _write(first, last, total, weight, mean, factor, out, column):
    """Write the sums divided by the scale, or the means."""
    for i in range(first, last):
        share = 1.0
        if mean:
            share = 1.0 / weight[i] if weight[i] > 0 else 0.0
        out[column, i] = total[i] * share * of_row(factor, i)
