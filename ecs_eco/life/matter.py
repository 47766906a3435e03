"""Matter: the amount of each substance in bodies and fields, and the ledger of its flows."""

from __future__ import annotations

import math
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.elementary import arrays, power, scalars
from ecs_eco.compiled.jit import njit
from ecs_eco.components import Body, Chemistry, Matter, Shape
from ecs_eco.space.shapes import volume as volume_of

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

FLOWS = {
    "endowed": "initial content without a source: founders, immigrants, newborns without a provider",
    "eaten": "from eaten organisms into their eaters",
    "reacted": "production minus consumption by reactions",
    "taken_up": "from fields into bodies: breathed, drunk, taken up by roots",
    "released": "from bodies into fields: excreted, leaked, released by decay, not assimilated",
    "emitted": "from bodies into their smell fields",
    "decayed": "decayed in fields",
    "brought_in": "from outside the world, minus outflow: air, rain, unlimited milk",
    "remains": "from dead organisms into their remains",
    "lost": "lost through deaths that leave no remains, or because no field contains the substance",
    "set": "set by hand, between ticks",
}
"""The flows of the ledger of matter and their meaning; positive [mol] if a holder gains the substance."""

MIGRATION = {
    "imported": "carried by migrants from other islands",
    "exported": "carried by migrants to other islands",
}
"""Further flows [mol] in the ledger of matter of an island."""

NUMBER = {flow: i for i, flow in enumerate([*FLOWS, *MIGRATION])}
NO_RESIDUE = np.zeros((0, 0), np.float32)


class Bodies(NamedTuple):
    """The content of a table's bodies: volume f64[rows] [L], molarity and residue f32[rows, substances]
    [mol/L]; residue is empty without the `Matter` component."""

    volume: np.ndarray
    molarity: np.ndarray
    residue: np.ndarray


def is_island(world: Any) -> bool:
    """Return whether a world can exchange migrants with other worlds; if so, its ledgers contain exports and
    imports."""
    return world.config is not None and world.config.archipelago is not None


def litres(radius: Any, shape: Any = None) -> Any:
    """Return the volume [L] of bodies: spheres, or a shape with the fields of `Shape`; `radius` is in meters."""
    r = np.asarray(radius, np.float64)
    if shape is None:
        return 4000 * math.pi / 3 * power(r, 3)
    length, width, height = (
        2 * np.asarray(half, np.float64) * r
        for half in (shape.half_length, shape.half_width, shape.half_height)
    )
    return 1000 * volume_of(length, width, height, np.asarray(shape.rounding, np.float64) * r)


def volumes(table: Table) -> np.ndarray:
    """Return the current volumes of a table's bodies [L]: f64[capacity]."""
    return litres(table[Body].radius, table[Shape] if Shape in table else None)


def newborn_volumes(table: Table, radius: Any) -> Any:
    """Return the volumes [L] of newborns with these radii [m] and the shape of their species."""
    return litres(radius, SimpleNamespace(**table.defaults[Shape]) if Shape in table else None)


def bodies(table: Table) -> Bodies:
    """Return the content of the bodies in a table with Chemistry, by row."""
    molarity = table[Chemistry].molarity
    if Matter in table:
        return Bodies(table[Matter].volume, molarity, table[Matter].residue)
    return Bodies(volumes(table), molarity, NO_RESIDUE)


class Books:
    """The ledger of matter of one world: the flows of each substance since the start of a page.

    `flows` f64[holders, substances, flows] [mol] are positive if they enter the holder, which is a table with
    Chemistry or a substance field. `stock` f64[holders, substances] [mol] is the holders' content at the
    start of the page.
    """

    def __init__(self, world: SpatialWorld) -> None:
        tables = [t.name for t in world.tables.values() if Chemistry in t]
        fields = [name for name, field in world.fields.items() if field.substance is not None]
        self.holders = {("table", name): i for i, name in enumerate(tables)}
        self.holders |= {("field", name): len(tables) + i for i, name in enumerate(fields)}
        self.ways = [*FLOWS, *(MIGRATION if is_island(world) else ())]
        self.flows = np.zeros((len(self.holders), len(world.substances), len(self.ways)))
        self.stock = stocks(world, self)

    @property
    def names(self) -> list[str]:
        """The names of the holders, tables first."""
        return [name for _, name in self.holders]

    def book(
        self,
        holder: tuple[str, str],
        flow: str,
        amount: np.ndarray | float,
        substance: int | slice = slice(None),
    ) -> None:
        """Record an amount [mol] that enters a holder: f64[substances], or a number for one substance."""
        self.flows[self.holders[holder], substance, NUMBER[flow]] += amount

    def watch(self, world: SpatialWorld) -> None:
        """Record the world's births and deaths from now on."""
        self.world = weakref.proxy(world)
        world.on_birth.append(self.born)
        world.on_death.append(self.died)
        world.on_departure.append(lambda table, rows, to: self.moved(table, rows, "exported"))
        world.on_arrival.append(lambda table, rows, origin: self.moved(table, rows, "imported"))

    def moved(self, table: Table, rows: np.ndarray, flow: str) -> None:
        """Record the content of migrants in rows i64[k] as "imported" or "exported"."""
        if ("table", table.name) in self.holders:
            sign = 1 if flow == "imported" else -1
            self.book(("table", table.name), flow, sign * total(rows, bodies(table)))

    def born(self, table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        """Record the content of newborns in rows i64[k]. Objects with a parent are that parent's remains."""
        if ("table", table.name) not in self.holders:
            return
        left = parents != 0 if table.species.is_object else np.zeros(rows.size, np.bool_)
        for flow, which in (("remains", rows[left]), ("endowed", rows[~left])):
            if which.size:
                self.book(("table", table.name), flow, total(which, bodies(table)))

    def died(self, table: Table, rows: np.ndarray) -> None:
        """Record the content of dying organisms in rows i64[k], before the rows are freed. Eaten organisms
        are empty if their eaters took their substances."""
        if ("table", table.name) not in self.holders:
            return
        left = remaining(self.world, table, rows)
        if table.species.remains is None or ("table", table.species.remains) not in self.holders:
            left[:] = False
        for flow, which in (("remains", rows[left]), ("lost", rows[~left])):
            if which.size:
                self.book(("table", table.name), flow, -total(which, bodies(table)))

    def turn(self, stock: np.ndarray) -> None:
        """Start a new page with these stocks."""
        self.stock = stock
        self.flows[...] = 0


def remaining(world: Any, table: Table, rows: np.ndarray) -> np.ndarray:
    """Return which dying organisms in rows i64[k] leave their bodies behind, bool[k]: all except eaten
    organisms and those whose cause of death is in `world.bodiless`."""
    gone = np.zeros(256, np.bool_)  # for every possible cause code
    gone[: len(world.causes)] = [c.startswith("eaten") or c in world.bodiless for c in world.causes]
    return ~gone[table.cause[rows] - 1]


def stocks(world: SpatialWorld, books: Books) -> np.ndarray:
    """Return the current amount of each substance in each holder: f64[holders, substances] [mol]."""
    out = np.zeros(books.flows.shape[:2])
    for (kind, name), i in books.holders.items():
        if kind == "table":
            table = world.tables[name]
            out[i] = total(table.rows(), bodies(table))
        else:
            field = world.fields[name]
            assert field.substance is not None
            out[i, world.substances.index(field.substance)] = field.held()
    return out


def book(world: SpatialWorld, table: Table, flow: str, amount: np.ndarray) -> None:
    """Record amounts f64[substances] [mol] that enter a table's bodies, in a world with a ledger."""
    if world.matter is not None:
        world.matter.book(("table", table.name), flow, amount)


def first_fields(world: SpatialWorld) -> dict[str, str]:
    """Return the name of the first field of each substance that has one, by substance."""
    return {
        field.substance: name for name, field in reversed(world.fields.items()) if field.substance is not None
    }


@contextmanager
def booked(world: SpatialWorld, table: Table, flow: str) -> Iterator[None]:
    """Record the gains and losses of a table's bodies within this context, for systems that change
    concentrations."""
    if world.matter is None:
        yield
        return
    rows = table.rows()
    before = total(rows, bodies(table))
    yield
    book(world, table, flow, total(rows, bodies(table)) - before)


def release(
    world: SpatialWorld, table: Table, amount: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray
) -> None:
    """Add amounts f64[k, substances] [mol] that have left bodies at positions f32[k] to the first field of
    each substance; a substance without a field is lost."""
    fields = first_fields(world)
    for s, substance in enumerate(world.substances):
        gone = float(amount[:, s].sum())
        if gone == 0:
            continue
        name = fields.get(substance)
        if name is not None:
            world.fields[name].give(x, y, z, np.ascontiguousarray(amount[:, s]))
        if world.matter is not None:
            world.matter.book(("table", table.name), "lost" if name is None else "released", -gone, s)
            if name is not None:
                world.matter.book(("field", name), "released", gone, s)


def part_lost(rate: Any) -> Any:
    """Return the share lost in a tick at a given rate [1/tick], a number or f64[k]."""
    return -arrays.expm1(-rate) if isinstance(rate, np.ndarray) else -scalars.expm1(-rate)


@njit
def held(bodies, row, s):
    """Return a concentration in float64."""
    rest = np.float64(bodies.residue[row, s]) if bodies.residue.size else 0.0
    return np.float64(bodies.molarity[row, s]) + rest


@njit
def hold(bodies, row, s, value):
    """Set a concentration; return the stored value."""
    bodies.molarity[row, s] = np.float32(value)
    if bodies.residue.size:
        bodies.residue[row, s] = np.float32(value - np.float64(bodies.molarity[row, s]))
    return held(bodies, row, s)


@njit
def total(rows: np.ndarray, bodies: Bodies) -> np.ndarray:
    """Return how much of each substance bodies contain in total: f64[substances] [mol]."""
    out = np.zeros(bodies.molarity.shape[1])
    for row in rows:
        for s in range(out.size):
            out[s] += held(bodies, row, s) * bodies.volume[row]
    return out
