"""Bodies exchange substances with fields: they breathe, drink, excrete and leak."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Body, Chemistry, Matter, Position, Shape
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_values
from ecs_eco.life.matter import Bodies, bodies, held, hold, part_lost
from ecs_eco.nervous.sensors.sense import place_of
from ecs_eco.space.geometry import Extent, Places, cell_of, into
from ecs_eco.space.seekers import Seekers

if TYPE_CHECKING:
    from ecs_eco.config.features.chemistry import Equilibrate, Release, Uptake
    from ecs_eco.engine.table import Table
    from ecs_eco.space.field import Field
    from ecs_eco.space.world import SpatialWorld

    Asked = tuple[Table, Any, str]  # one kind of body, a process and its key

ALL = np.zeros(0, np.bool_)
OUTSIDE = np.zeros(0)


class Cells(NamedTuple):
    """The cells of a field, for kernels."""

    nx: int  # along x, y and z
    ny: int
    nz: int
    inverse: np.ndarray  # f32[3], cells per meter


class Mouths(NamedTuple):
    """Positions of mouths on bodies, for kernels: arrays [rows], or numbers shared by all."""

    heading: np.ndarray  # [rad]
    radius: np.ndarray  # [m]
    forward: Number  # forward, to the left and up, in body radii
    left: Number
    up: Number


KINDS = "uptake", "equilibrate", "release"


class ExchangeMatter(System):
    """Bodies take up substances from fields, then equilibrate with them, then release substances.

    All bodies of all kinds do so simultaneously. Uptake is limited by the content of a cell; if it does not
    contain enough, all bodies get the same share of their demand, however many uptakes they have.
    Equilibration is solved exactly for a body and its part of the cell. All steps run in canonical order.
    """

    needs = (Position, Body, Chemistry, Matter)
    phase = "metabolise"
    submodel = Submodel("Exchange of substances", reads=("exchange",), changes=("Chemistry", "Matter"))
    asked_for = staticmethod(lambda table: bool(table.species.exchange))
    world: SpatialWorld
    _asked: dict[tuple[int, int, str], list[Asked]]

    def process(self, *_args: object) -> None:
        """Exchange, for all bodies, the substances that their species list, one process and one field at a
        time."""
        self._asked, world = {}, self.world
        super().process()
        for (kind, _, field), asked in sorted(self._asked.items(), key=lambda one: one[0]):
            if kind < 2:
                (self.equilibrate if kind else self.take_up)(world, world.fields[field], asked)
            else:
                for table, way, key in asked:
                    self.release(table, world, way, key)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Record the exchanges of one kind of body; all but uptakes are numbered within process and field."""
        seen: dict[tuple[int, str], int] = {}
        ways = enumerate(table.species.exchange if table.n else ())
        for number, way in sorted(ways, key=lambda way: str(vars(way[1]))):
            kind = KINDS.index(way.kind), way.field or ""
            seen[kind] = seen.get(kind, -1) + 1 if kind[0] else 0
            self._asked.setdefault((kind[0], seen[kind], kind[1]), []).append(
                (table, way, f"exchange.{number}.")
            )

    def take_up(self, world: SpatialWorld, field: Field, asked: list[Asked]) -> None:
        """Take up the amounts that bodies of all kinds demand from one field or, if it does not contain
        enough, their shares of its content."""
        s, value = world.substances.index(field.substance or ""), field.value.reshape(-1)
        total, wants = np.zeros(value.size), []
        most = {table.name: np.zeros(table.high) for table, _, _ in asked}
        for table, way, key in asked:
            _, rows, cell = self.places(table, world, way, key)
            names = f"{key}rate", f"{key}half", f"{key}concentration_max"
            limits = way.rate, way.half or 0.0, way.concentration_max or np.inf
            rate, half, until = own_values(table, dict(zip(names, limits, strict=True)))
            rates, does = np.zeros(rows.size), self.doing(table, way)
            demand(rows, cell, does, rate * world.dt, half, value, rates, most[table.name])
            wants.append((rows, cell, rates, until))
        for (table, _, _), (rows, cell, wanted, until) in zip(asked, wants, strict=True):
            limit(rows, cell, bodies(table), s, until, most[table.name], wanted, total)
        before = value.copy()
        for (table, way, _), (rows, cell, wanted, _) in zip(asked, wants, strict=True):
            moved = take(rows, cell, wanted, bodies(table), s, before, total, value, field.litres)
            self.book(table, world, way.field, "taken_up", s, moved)

    def equilibrate(self, world: SpatialWorld, field: Field, asked: list[Asked]) -> None:
        """Equilibrate concentrations in bodies of all kinds with the concentrations around them in one field."""
        s, value = world.substances.index(field.substance or ""), field.value.reshape(-1)
        before, total = value.copy(), np.zeros(value.size)
        places = [self.places(table, world, way, key)[1:] for table, way, key in asked]
        for (table, _, _), (rows, cell) in zip(asked, places, strict=True):
            np.add.at(total, cell, bodies(table).volume[rows])
        for (table, way, key), (rows, cell) in zip(asked, places, strict=True):
            rate, partition = own_values(table, {f"{key}rate": way.rate, f"{key}partition": way.partition})
            moved = pass_skin(
                rows, cell, bodies(table), s, rate * world.dt, partition, before, total, value, field.litres
            )
            self.book(table, world, way.field, "taken_up", s, moved)

    def release(self, table: Table, world: SpatialWorld, way: Release, key: str) -> None:
        """Release a share of each body's content in excess of the amount that it keeps."""
        rate, above = own_values(table, {f"{key}rate": way.rate, f"{key}above": way.above})
        s, share = world.substances.index(way.substance), part_lost(rate * world.dt)
        if way.field is None:
            rows = world.index(table).rows
            cell, value, litres = rows, OUTSIDE, 1.0
        else:
            field, rows, cell = self.places(table, world, way, key)
            value, litres = field.value.reshape(-1), field.litres
        moved = give(rows, cell, self.doing(table, way), bodies(table), s, share, above, value, litres)
        self.book(table, world, way.field, "lost" if way.field is None else "released", s, -moved)

    def book(
        self, table: Table, world: SpatialWorld, field: str | None, flow: str, s: int, moved: float
    ) -> None:
        """Record the amounts [mol] that have entered the bodies."""
        if world.matter is not None:
            world.matter.book(("table", table.name), flow, moved, s)
            if field is not None:
                world.matter.book(("field", field), flow, -moved, s)

    def doing(self, table: Table, way: Uptake | Release) -> np.ndarray:
        """Return which organisms execute the required action, bool[capacity]; empty if no action is required."""
        return ALL if way.action is None else table.species.nerves.doing(table, way.action)

    def places(
        self, table: Table, world: SpatialWorld, way: Uptake | Release | Equilibrate, key: str
    ) -> tuple[Field, np.ndarray, np.ndarray]:
        """Return the field, the living rows in canonical order i64[n], and the field cell at each mouth i64[n]."""
        field, index = world.fields[way.field or ""], world.index(table)
        cell, space = np.empty(index.n, np.int64), world.space
        at = own_values(
            table, {f"{key}at.{axis}": np.float32(v) for axis, v in enumerate([*way.at, 0.0, 0.0][:3])}
        )
        x, y, z = index.x, index.y, index.z
        if Shape in table:
            each = [v[index.rows] if isinstance(v, np.ndarray) else v for v in at]
            x, y, z = place_of(table, Seekers(world, table), -1, each, world.space)
            at = (np.float32(0),) * 3
        places, mouths = Places(x, y, z), Mouths(table[Position].heading, table[Body].radius, *at)
        find(index.rows, places, mouths, space.extent, Cells(*field.shape, field.inverse), cell)
        return field, index.rows, cell


@njit
def find(
    rows: np.ndarray, places: Places, mouths: Mouths, space: Extent, cells: Cells, cell: np.ndarray
) -> None:
    """Write the field cell at each body's mouth."""
    (x, y, z), (heading, radius, forward, left, above) = places, mouths
    nx, ny, nz, inverse = cells
    for i in range(rows.size):
        r, cos, sin = radius[rows[i]], np.cos(heading[rows[i]]), np.sin(heading[rows[i]])
        ahead, aside = of_row(forward, rows[i]), of_row(left, rows[i])
        px = into(x[i] + r * (ahead * cos - aside * sin), space.lengths[0], space.torus)
        py = into(y[i] + r * (ahead * sin + aside * cos), space.lengths[1], space.torus)
        pz = z[i] + r * of_row(above, rows[i])
        cell[i] = (cell_of(pz * inverse[2], nz) * ny + cell_of(py * inverse[1], ny)) * nx + cell_of(
            px * inverse[0], nx
        )


@njit
def demand(rows, cell, does, rate, half, value, wanted, most):
    """Write each body's demand for a substance, at most `rate` [mol/L], to `wanted` f64[n], and add it to the
    demand of all uptakes of that body, `most` f64[rows]."""
    for i in range(rows.size):
        row, c = rows[i], value[cell[i]]
        if does.size and not does[row]:
            continue
        wanted[i], slow = of_row(rate, row), of_row(half, row)
        if slow != 0:
            wanted[i] = wanted[i] * c / (slow + c)
        most[row] += wanted[i]


@njit
def limit(rows, cell, bodies, s, until, most, wanted, total):
    """Reduce demands so that bodies are not filled above a concentration; convert them to amounts [mol], and
    add these to the total demand on their cells, `total` f64[cells]."""
    for i in range(rows.size):
        if wanted[i] > 0:
            row = rows[i]
            room = (of_row(until, row) - held(bodies, row, s)) * (wanted[i] / most[row])
            wanted[i] = max(min(wanted[i], room), 0.0) * bodies.volume[row]
            total[cell[i]] += wanted[i]


@njit
def take(
    rows: np.ndarray,
    cell: np.ndarray,
    wanted: np.ndarray,
    bodies: Bodies,
    s: int,
    stock: np.ndarray,
    total: np.ndarray,
    value: np.ndarray,
    litres: float,
) -> float:
    """Move amounts [mol] from the cells of a field into bodies, or equal shares of them where the total demand
    on a cell, `total` f64[cells], exceeds its `stock` f64[cells] [mol/L]; return the total [mol]."""
    volume, moved = bodies.volume, 0.0
    for i in range(rows.size):
        if wanted[i] > 0:
            row, k = rows[i], cell[i]
            before, share = held(bodies, row, s), min(1.0, stock[k] * litres / total[k])
            amount = (hold(bodies, row, s, before + wanted[i] * share / volume[row]) - before) * volume[row]
            value[k] = max(value[k] - amount / litres, 0.0)
            moved += amount
    return moved


@njit
def pass_skin(
    rows: np.ndarray,
    cell: np.ndarray,
    bodies: Bodies,
    s: int,
    rate: Number,
    partition: Number,
    before: np.ndarray,
    total: np.ndarray,
    value: np.ndarray,
    litres: float,
) -> float:
    """Exchange a substance between bodies and their parts of a cell, which are proportional to body volume;
    `total` f64[cells] is the volume of all bodies in a cell. Return the amount [mol] that has entered bodies."""
    volume, moved = bodies.volume, 0.0
    for i in range(rows.size):
        row, k = rows[i], cell[i]
        c, balance = held(bodies, row, s), of_row(partition, row)
        # y = partition × c_field − c falls as exp(−rate × crowd × t)
        crowd = 1.0 + balance * total[k] / litres
        change = (balance * before[k] - c) * -math.expm1(-of_row(rate, row) * crowd) / crowd
        amount = (hold(bodies, row, s, max(c + change, 0.0)) - c) * volume[row]
        value[k] = max(value[k] - amount / litres, 0.0)
        moved += amount
    return moved


@njit
def give(
    rows: np.ndarray,
    cell: np.ndarray,
    does: np.ndarray,
    bodies: Bodies,
    s: int,
    share: Number,
    above: Number,
    value: np.ndarray,
    litres: float,
) -> float:
    """Move a share of the substance that bodies hold in excess of a concentration into the cells of a field,
    or out of the world if there is no field; return the total [mol]."""
    volume, moved = bodies.volume, 0.0
    for i in range(rows.size):
        row = rows[i]
        c, least = held(bodies, row, s), of_row(above, row)
        if c <= least or (does.size and not does[row]):
            continue
        amount = (c - hold(bodies, row, s, c - (c - least) * of_row(share, row))) * volume[row]
        if value.size:
            value[cell[i]] += amount / litres
        moved += amount
    return moved
