"""The sensor for a property of the organism's own body (interoception)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco._lazy import stored_name
from ecs_eco.compiled.elementary import power
from ecs_eco.compiled.jit import lone_njit
from ecs_eco.compiled.per_row import of_row
from ecs_eco.components import Biology, Body, Chemistry, Metabolism, Physical, Shape
from ecs_eco.nervous.sensors.sense import Sense, of_sensor, place_of
from ecs_eco.space.bodies import extents
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.shapes import volume

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def own_column(table: "Table", name: str, substances: list[str]) -> np.ndarray:
    """Return the column of a property, a substance or a Component.field by name: f32[capacity], or
    u8[capacity] for sex and the field's own type for a field."""
    if name == "energy":
        return table[Metabolism].energy
    if name in ("age", "fertility"):
        return getattr(table[Biology], name)
    if name in substances:
        return table[Chemistry].molarity[:, substances.index(name)]
    name = table.species.feels().get(name, name)
    if "." in name:
        component, _, field = name.partition(".")
        return getattr(
            next(v for c, v in table.columns.items() if component in (c.__name__, stored_name(c))), field
        )
    if name == "sex":
        return table[Biology].sex
    if name in ("mass", "radius"):
        return getattr(table[Body], name)
    if name == "volume":
        with np.errstate(over="ignore"):
            if Shape in table:
                return volume(*extents(table)).astype(np.float32)
            return np.float32(4 / 3 * np.pi) * power(table[Body].radius, 3)
    return getattr(table[Physical], name)


def own(
    property: str, scale: float, substances: list[str], number: int = 0, at: Sequence[float] = ()
) -> Sense:
    """Feel a property of the organism's own body at a point on it, as a share of `scale`.

    A body is uniform, except that the pressure in a compressible body depends on depth.
    """

    shared = np.float32(1.0 / scale)

    def read(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        factor: Any = shared
        if table.species.traits:
            factor = 1.0 / of_sensor(table, seekers, number, scale=scale)[0]
            factor = factor.astype(np.float32) if isinstance(factor, np.ndarray) else np.float32(factor)
        value = own_column(table, property, substances)
        if property == "pressure" and table.species.body.compressible and any(at):
            value = value.copy()
            value[seekers.rows] = world.surroundings(
                "pressure", *place_of(table, seekers, number, at, world.space)
            )
        world.split(_own, seekers.n, value, seekers.rows, factor, out.T, column, work=seekers.n // 30)

    return Sense(read)


@lone_njit
def _own(first, last, value, rows, factor, out, column):
    for k in range(last - first):
        i = np.uint64(first + k)
        out[column, i] = value[np.uint64(rows[i])] * of_row(factor, i)
