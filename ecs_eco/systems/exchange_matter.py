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
    from ecs_eco.config.features.chemistry import Equilibrate, Release, Uptake
    from ecs_eco.engine.table import Table
    from ecs_eco.space.field import Field
    from ecs_eco.space.index import Index
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
NO_LIMIT = 1e30


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
        for (kind, _), every in sorted(self._asked.items(), key=lambda one: one[0]):
            for one in every:
                one.look()
            (take_up, equilibrate, release)[kind](every, self.world.dt)
            for one in every:
                one.apply()

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Record the exchanges of one kind of body, by process and substance."""
        ways = enumerate(table.species.exchange if table.n else ())
        for number, way in sorted(ways, key=lambda way: str(vars(way[1]))):
            field = None if way.field is None else world.fields[way.field]
            name = way.substance if way.kind == "release" else (field and field.substance)
            s = world.substances.index(name or "")
            one = Exchange(table, world, way, f"exchange.{number}.", field, s)
            self._asked.setdefault((KINDS.index(way.kind), s), []).append(one)


class Exchange:
    """An exchange of one substance by all members of a table. All arrays f64[n] are in canonical order, which
    is the same for all exchanges of the table."""

    def __init__(
        self,
        table: Table,
        world: SpatialWorld,
        way: Uptake | Equilibrate | Release,
        key: str,
        field: Field | None,
        s: int,
    ) -> None:
        self.table, self.world, self.way, self.key, self.field, self.s = table, world, way, key, field, s

    def look(self) -> None:
        """Find the organisms that are not dying, the concentrations in and around them [mol/L], and their
        volumes [L]."""
        index, s = self.world.index(self.table), self.s
        living = self.table.cause[index.rows] == 0
        self.rows, self.bodies = index.rows[living], bodies(self.table)
        self.held = self.bodies.molarity[self.rows, s].astype(np.float64)
        if self.bodies.residue.size:
            self.held += self.bodies.residue[self.rows, s]
        self.volume, self.change = self.bodies.volume[self.rows], np.zeros(self.rows.size)
        action = getattr(self.way, "action", None)
        self.acting = (
            True if action is None else self.table.species.nerves.doing(self.table, action)[self.rows]
        )
        self.cell, self.litres, self.around = self.rows, 1.0, OUTSIDE
        if self.field is not None:
            self.cell, self.litres = self._cells(index, self.field)[living], self.field.litres
            self.around = self.field.value.reshape(-1)[self.cell]

    def own(self, *names: str, without: float = 0.0) -> list[np.ndarray]:
        """Return values of the exchange for each organism: f64[n]; `without` replaces absent ones."""
        values = {f"{self.key}{name}": getattr(self.way, name) for name in names}
        found = own_values(self.table, {k: without if v is None else v for k, v in values.items()})
        return [np.full(self.rows.size, of_row(value, self.rows), np.float64) for value in found]

    def apply(self) -> None:
        """Change the concentrations in bodies by `change` [mol/L], and book the amounts that have moved."""
        value = OUTSIDE if self.field is None else self.field.value.reshape(-1)
        moved = move(self.rows, self.cell, self.bodies, self.s, self.change, value, self.litres)
        if (books := self.world.matter) is not None:
            flow = "taken_up" if self.way.kind != "release" else "lost" if self.field is None else "released"
            books.book(("table", self.table.name), flow, moved, self.s)
            if self.field is not None:
                books.book(("field", self.way.field), flow, -moved, self.s)

    def _cells(self, index: Index, field: Field) -> np.ndarray:
        """Return the field cell at each mouth, by entry of the index: i64[entries]."""
        table, space, cell = self.table, self.world.space, np.empty(index.n, np.int64)
        at = own_values(
            table,
            {f"{self.key}at.{axis}": np.float32(v) for axis, v in enumerate([*self.way.at, 0.0, 0.0][:3])},
        )
        x, y, z = index.x, index.y, index.z
        if Shape in table:
            each = [v[index.rows] if isinstance(v, np.ndarray) else v for v in at]
            x, y, z = place_of(table, Seekers(self.world, table), -1, each, space)
            at = (np.float32(0),) * 3
        places, mouths = Places(x, y, z), Mouths(table[Position].heading, table[Body].radius, *at)
        find(index.rows, places, mouths, space.extent, Cells(*field.shape, field.inverse), cell)
        return cell


def take_up(every: list[Exchange], dt: float) -> None:
    """Set the changes by uptake: rate c/(half + c) (Michaelis & Menten 1913), limited by the space left in each
    body and by the content of each cell."""
    wanted = []
    for one in every:
        rate, half = one.own("rate", "half")
        rate *= dt * np.asarray(one.acting)
        wanted.append(np.divide(rate * one.around, half + one.around, out=rate, where=half > 0))
    amounts = []
    for one, demand, most in zip(every, wanted, of_body(every, wanted), strict=True):
        (until,) = one.own("concentration_max", without=NO_LIMIT)
        left = (until - one.held) * share(demand, most)
        amounts.append(np.minimum(demand, left).clip(0.0) * one.volume)
    for one, amount, total in zip(every, amounts, of_cell(every, amounts), strict=True):
        there = one.around * one.litres
        one.change = amount * np.where(total > there, share(there, total), 1.0) / one.volume


def equilibrate(every: list[Exchange], dt: float) -> None:
    """Set the changes by diffusion (Fick 1855): y = partition × c_field − c falls as exp(−rate × crowd × t)."""
    rates = [one.own("rate")[0] * dt for one in every]
    sums = of_body(every, rates)
    parts = [share(rate, total) for rate, total in zip(rates, sums, strict=True)]
    crowds = of_cell(every, [one.volume * part for one, part in zip(every, parts, strict=True)])
    for one, total, part, volume in zip(every, sums, parts, crowds, strict=True):
        (partition,) = one.own("partition")
        crowd = 1.0 + partition * volume / one.litres
        one.change = (partition * one.around - one.held) * part_lost(total * crowd) * part / crowd


def release(every: list[Exchange], dt: float) -> None:
    """Set the changes by release: dc/dt = −rate (c − above) while c > above."""
    limits, rates = [], []
    for one in every:
        rate, above = one.own("rate", "above")
        limits.append(above)
        rates.append(rate * dt * (one.acting & (one.held > above)))
    for one, above, rate, total in zip(every, limits, rates, of_body(every, rates), strict=True):
        one.change = (above - one.held) * (part_lost(total) * share(rate, total))


def share(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Return part / whole, or 0 if both are 0."""
    return np.divide(part, whole, out=np.zeros_like(whole), where=whole > 0)


def of_body(every: list[Exchange], values: list[np.ndarray]) -> list[np.ndarray]:
    """Return the sums of values f64[n] over all exchanges of the same table."""
    sums: dict[str, Any] = {}
    for one, value in zip(every, values, strict=True):
        sums[one.table.name] = sums.get(one.table.name, 0.0) + value
    return [sums[one.table.name] for one in every]


def of_cell(every: list[Exchange], values: list[np.ndarray]) -> list[np.ndarray]:
    """Return, for each organism, the sum of values f64[n] over all exchanges with its cell."""
    sums: dict[str, np.ndarray] = {}
    for one, value in zip(every, values, strict=True):
        assert one.field is not None
        np.add.at(sums.setdefault(one.way.field or "", np.zeros(one.field.value.size)), one.cell, value)
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
