"""The sensor for a property of the organism's own body (interoception)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco._lazy import stored_name
from ecs_eco.compiled.elementary import power
from ecs_eco.compiled.jit import lone_njit
from ecs_eco.compiled.numba_version import interpreted
from ecs_eco.compiled.per_row import of_row
from ecs_eco.components import Biology, Body, Chemistry, Metabolism, Physical, Shape
from ecs_eco.engine.addresses import address_of, column_at
from ecs_eco.engine.schema import Columns
from ecs_eco.nervous.sensors.sense import Reading, Sense, of_sensor, place_of
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

    def plain(table: "Table") -> np.ndarray | None:
        """Return the column if the sense only reads it: f32[capacity]."""
        if table.species.traits or property == "volume" or (property == "pressure" and any(at)):
            return None
        value = own_column(table, property, substances)
        return value if type(value) is np.ndarray and value.dtype == np.float32 else None

    return Sense(read, together=feel_together, detail=(plain, shared))


class Plain(NamedTuple):
    """Columns that are read unchanged, given by their addresses, and the senses that read other values."""

    made_from: tuple[Any, ...] = ()  # valid until these values change
    others: tuple[tuple[Sense, int], ...] = ()
    arrays: tuple[np.ndarray, ...] = ()  # kept so that addresses stay valid
    addresses: np.ndarray = np.empty(0, np.uint64)
    steps: np.ndarray = np.empty(0, np.int64)  # stride between rows
    sizes: np.ndarray = np.empty(0, np.int64)  # number of elements from the first row to the last
    factors: np.ndarray = np.empty(0, np.float32)
    columns: np.ndarray = np.empty(0, np.int64)  # columns of the observations

    @classmethod
    def of(cls, made_from: tuple[Any, ...], table: "Table", senses: list[tuple[Sense, int]]) -> "Plain":
        """Return the group of a table's senses, each with its first column."""
        arrays = [None if interpreted() else sense.detail[0](table) for sense, _ in senses]  # needs addresses
        read = [
            (a, sense.detail[1], column)
            for a, (sense, column) in zip(arrays, senses, strict=True)
            if a is not None
        ]
        return cls(
            made_from,
            tuple(it for a, it in zip(arrays, senses, strict=True) if a is None),
            tuple(a for a, _, _ in read),
            np.array([address_of(a) for a, _, _ in read], np.uint64),
            np.array([a.strides[0] // a.itemsize for a, _, _ in read], np.int64),
            np.array([(a.size - 1) * (a.strides[0] // a.itemsize) + 1 for a, _, _ in read], np.int64),
            np.array([factor for _, factor, _ in read], np.float32),
            np.array([column for _, _, column in read], np.int64),
        )


def feel_together(senses: list[tuple[Sense, int]]) -> Reading:
    """Return a function that feels properties of the organism's own body for several senses at once, each
    with its first column."""
    kept = Plain()

    def read(world: "SpatialWorld", table: "Table", seekers: Seekers, out: np.ndarray, column: int) -> None:
        nonlocal kept
        plain, now = kept, (table, bool(table.species.traits), Columns.replaced)
        if plain.made_from != now:
            plain = kept = Plain.of(now, table, senses)
        if plain.arrays:
            world.split(
                _own_columns,
                seekers.n,
                *plain[3:],
                seekers.rows,
                out.T,
                work=seekers.n * len(plain.arrays) // 30,
            )
        for one, first in plain.others:
            one(world, table, seekers, out, first)

    return read


@lone_njit
def _own_columns(first, last, addresses, steps, sizes, factors, columns, rows, out):
    """Write the rows' values in each column f32[capacity], given by its address, times the column's factor."""
    for c in range(columns.size):
        value, step, factor = column_at(addresses[c], np.float32, sizes[c]), np.uint64(steps[c]), factors[c]
        for k in range(last - first):
            i = np.uint64(first + k)
            out[columns[c], i] = value[np.uint64(rows[i]) * step] * factor


@lone_njit
def _own(first, last, value, rows, factor, out, column):
    for k in range(last - first):
        i = np.uint64(first + k)
        out[column, i] = value[np.uint64(rows[i])] * of_row(factor, i)
