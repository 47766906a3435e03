"""Bodies exchange substances with fields: they breathe, drink, excrete and leak."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Body, Chemistry, Matter, Position, Shape
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_values
from ecs_eco.life.matter import bodies, held, hold, part_lost
from ecs_eco.nervous.sensors.sense import place_of
from ecs_eco.space.geometry import Extent, Places, cell_of, into
from ecs_eco.space.seekers import Seekers

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.field import Field
    from ecs_eco.space.world import SpatialWorld

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
NO_LIMIT, TINY = 1e30, 1e-300


class ExchangeMatter(System):
    """Bodies take up substances from fields, then equilibrate with them, then release substances.

    All bodies of all kinds do so simultaneously, and so do all uptakes, equilibrations or releases of one
    substance by one body. Uptake is limited by the content of a cell; if it does not contain enough, all
    bodies get the same share of their demand, however many uptakes they have. Equilibration and release are
    solved exactly for a body and its part of the cell; if a body has several, each contributes in proportion
    to its rate. Dying organisms exchange nothing. All steps run in canonical order.
    """

    needs = (Position, Body, Chemistry, Matter)
    phase = "metabolise"
    submodel = Submodel("Exchange of substances", reads=("exchange",), changes=("Chemistry", "Matter"))
    asked_for = staticmethod(lambda table: bool(table.species.exchange))
    world: SpatialWorld
    _asked: dict[tuple[int, int], list[Exchange]]

    def process(self, *_args: object) -> None:
        """Exchange, for all bodies, the substances that their species list, one process and one substance at a
        time."""
        self._asked = {}
        super().process()
        for kind, s in sorted(self._asked):
            every = self._asked[kind, s]
            for one in every:
                one.look()
            (take_up, equilibrate, release)[kind](every, self.world.dt)
            for one in every:
                one.apply()

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Record the exchanges of one kind of body, by process and substance."""
        if table.n == 0:
            return
        some = Living(table, world)
        for number, _ in sorted(enumerate(table.species.exchange), key=lambda way: str(vars(way[1]))):
            one = Exchange(some, number)
            self._asked.setdefault((KINDS.index(one.way.kind), one.s), []).append(one)


class Living:
    """The members of a table that are not dying, in canonical order."""

    def __init__(self, table: Table, world: SpatialWorld) -> None:
        self.table, self.world, self.index = table, world, world.index(table)
        self.rows, self.bodies = self.index.rows, bodies(table)
        dying = table.cause[self.rows] != 0
        self.which: Any = ~dying if dying.any() else slice(None)  # entries of the index
        self.rows = self.rows[self.which]
        self.volume = self.bodies.volume[self.rows]  # f64[n] [L]


class Exchange:
    """An exchange of one substance by all members of a table; arrays f64[n] are in canonical order."""

    change: np.ndarray  # [mol/L]

    def __init__(self, some: Living, number: int) -> None:
        self.some, self.key = some, f"exchange.{number}."
        self.way = way = some.table.species.exchange[number]
        self.field: Field | None = None if way.field is None else some.world.fields[way.field]
        substance = way.substance if self.field is None else self.field.substance or ""
        self.s = some.world.substances.index(substance)

    def look(self) -> None:
        """Find the concentrations in and around bodies [mol/L], and which organisms act."""
        some, table = self.some, self.some.table
        action = getattr(self.way, "action", None)
        self.acting = True if action is None else table.species.nerves.doing(table, action)[some.rows]
        self.cell, self.litres, self.value = some.rows, 1.0, OUTSIDE
        if self.field is not None:
            self.cell, self.litres = self._cells(self.field)[some.which], self.field.litres
            self.value = self.field.value.reshape(-1)
        self.held, self.around = concentrations(some.rows, some.bodies, self.s, self.cell, self.value)

    def own(self, **values: float) -> list[Any]:
        """Return values of the exchange: a number, or f64[n] if genes code for any of them."""
        found = own_values(self.some.table, {f"{self.key}{name}": value for name, value in values.items()})
        return [v[self.some.rows].astype(np.float64) if isinstance(v, np.ndarray) else v for v in found]

    def apply(self) -> None:
        """Change the concentrations in bodies by `change` [mol/L], and book the amounts that have moved."""
        some = self.some
        moved = move(some.rows, self.cell, some.bodies, self.s, self.change, self.value, self.litres)
        if (books := some.world.matter) is not None:
            flow = "taken_up" if self.way.kind != "release" else "lost" if self.field is None else "released"
            books.book(("table", some.table.name), flow, moved, self.s)
            if self.field is not None:
                books.book(("field", self.way.field), flow, -moved, self.s)

    def _cells(self, field: Field) -> np.ndarray:
        """Return the field cell at each mouth, by entry of the index: i64[entries]."""
        table, world, index = self.some.table, self.some.world, self.some.index
        cell, space = np.empty(index.n, np.int64), world.space
        at = own_values(
            table,
            {f"{self.key}at.{axis}": np.float32(v) for axis, v in enumerate([*self.way.at, 0.0, 0.0][:3])},
        )
        x, y, z = index.x, index.y, index.z
        if Shape in table:
            each = [v[index.rows] if isinstance(v, np.ndarray) else v for v in at]
            x, y, z = place_of(table, Seekers(world, table), -1, each, space)
            at = (np.float32(0),) * 3
        places, mouths = Places(x, y, z), Mouths(table[Position].heading, table[Body].radius, *at)
        find(index.rows, places, mouths, space.extent, Cells(*field.shape, field.inverse), cell)
        return cell


def take_up(every: list[Exchange], dt: float) -> None:
    """Set the changes by uptake: rate c/(half + c) (Michaelis & Menten 1913), limited by the space left in each
    body and by the content of each cell."""
    wanted, amounts = [], []
    for one in every:
        rate, half = one.own(rate=one.way.rate, half=one.way.half or 0.0)
        demand = np.where(one.acting, rate * dt, np.zeros_like(one.held))
        slow = np.maximum(half + one.around, TINY)  # a gene may code for a half of 0
        wanted.append(demand if one.way.half is None else demand * one.around / slow)
    for one, demand, (part, _) in zip(every, wanted, of_body(every, wanted), strict=True):
        (until,) = one.own(concentration_max=one.way.concentration_max or NO_LIMIT)
        amounts.append(np.maximum(np.minimum(demand, (until - one.held) * part), 0.0) * one.some.volume)
    for one, amount, total in zip(every, amounts, of_cell(every, amounts), strict=True):
        there = one.around * one.litres
        share = np.divide(there, total, out=np.ones(there.size), where=total > there)
        one.change = amount * share / one.some.volume


def equilibrate(every: list[Exchange], dt: float) -> None:
    """Set the changes by diffusion (Fick 1855): y = partition × c_field − c falls as exp(−rate × crowd × t)."""
    rates = of_body(every, [one.own(rate=one.way.rate)[0] * dt for one in every])
    crowds = of_cell(every, [one.some.volume * part for one, (part, _) in zip(every, rates, strict=True)])
    for one, (part, total), volume in zip(every, rates, crowds, strict=True):
        (partition,) = one.own(partition=one.way.partition)
        crowd = 1.0 + partition * volume / one.litres
        one.change = (partition * one.around - one.held) * part_lost(total * crowd) * part / crowd


def release(every: list[Exchange], dt: float) -> None:
    """Set the changes by release: dc/dt = −rate (c − above) while c > above."""
    limits, rates = [], []
    for one in every:
        rate, above = one.own(rate=one.way.rate, above=one.way.above)
        limits.append(above)
        rates.append(np.where(one.acting & (one.held > above), rate * dt, 0.0))
    for one, above, (part, total) in zip(every, limits, of_body(every, rates), strict=True):
        one.change = (above - one.held) * (part_lost(total) * part)


def of_body(every: list[Exchange], rates: list[Any]) -> list[tuple[Any, Any]]:
    """Return, for each exchange, its share of the rates of all exchanges of a body, and the sum of these rates:
    numbers or f64[n]."""
    sums: dict[str, list[Any]] = {}
    for one, rate in zip(every, rates, strict=True):
        sums.setdefault(one.some.table.name, []).append(rate)
    out: list[tuple[Any, Any]] = []
    for one, rate in zip(every, rates, strict=True):
        total = sum(some := sums[one.some.table.name])
        out.append((1.0 if len(some) == 1 else rate / np.maximum(total, TINY), total))
    return out


def of_cell(every: list[Exchange], amounts: list[np.ndarray]) -> list[np.ndarray]:
    """Return, for each organism, the sum of amounts f64[n] over all exchanges with its cell."""
    sums: dict[str, np.ndarray] = {}
    for one, amount in zip(every, amounts, strict=True):
        assert one.field is not None
        np.add.at(sums.setdefault(one.way.field or "", np.zeros(one.field.value.size)), one.cell, amount)
    return [sums[one.way.field or ""][one.cell] for one in every]


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
def concentrations(rows, bodies, s, cell, value):
    """Return the concentrations [mol/L] in bodies and, if they exchange with a field, in their cells: f64[n]."""
    inside, outside = np.empty(rows.size), np.zeros(rows.size)
    for i in range(rows.size):
        inside[i] = held(bodies, rows[i], s)
        if value.size:
            outside[i] = value[cell[i]]
    return inside, outside


@njit
def move(rows, cell, bodies, s, change, value, litres):
    """Change concentrations in bodies by `change` f64[n] [mol/L] and take the amounts from the cells of a field
    f64[cells], or from outside the world if it is empty; return the total [mol]."""
    moved = 0.0
    for i in range(rows.size):
        if change[i] != 0:
            c = held(bodies, rows[i], s)
            amount = (hold(bodies, rows[i], s, max(c + change[i], 0.0)) - c) * bodies.volume[rows[i]]
            if value.size:
                value[cell[i]] = max(value[cell[i]] - amount / litres, 0.0)
            moved += amount
    return moved
