"""Matter: what bodies and fields hold of each substance, and the books of what comes and goes."""

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
    "endowed": "born with, from nowhere: founders, immigrants, newborn for whom nobody provides",
    "eaten": "taken from the eaten, into their eaters",
    "reacted": "made, less what was used up, by reactions",
    "taken_up": "from fields into bodies: breathed, drunk, taken up by roots",
    "released": "from bodies into fields: excreted, leaked, given back by what decays, not assimilated",
    "emitted": "from bodies into the fields of their smells",
    "decayed": "decayed in fields",
    "brought_in": "from outside of the world, less what went there: air, rain, milk of which no ewe runs out",
    "remains": "from the dead into what remains of them",
    "lost": "gone: with the dead who leave nothing, or to where no field holds it",
    "set": "set by hand, between ticks",
}
"""The flows of the ledger of matter → what they are; positive into what holds a substance [mol]."""

MIGRATION = {
    "imported": "brought along by migrants from other islands",
    "exported": "taken along by migrants to other islands",
}
"""Further flows of the ledger of matter of a world that is an island [mol]."""

NUMBER = {flow: i for i, flow in enumerate([*FLOWS, *MIGRATION])}
NO_RESIDUE = np.zeros((0, 0), np.float32)


class Bodies(NamedTuple):
    """What the bodies of a table hold: volume f64[rows] [L], molarity and residue f32[rows, substances]
    [mol/L]; no residue where there is no component `Matter`."""

    volume: np.ndarray
    molarity: np.ndarray
    residue: np.ndarray


def is_island(world: Any) -> bool:
    """Return whether a world may exchange migrants with others: its ledgers have export and import."""
    return world.config is not None and world.config.archipelago is not None


def litres(radius: Any, shape: Any = None) -> Any:
    """Return the volume of bodies [L]: of spheres, or of a shape that has the fields of `Shape`; `radius` in
    metres."""
    r = np.asarray(radius, np.float64)
    if shape is None:
        return 4000 * math.pi / 3 * power(r, 3)
    length, width, height = (
        2 * np.asarray(half, np.float64) * r
        for half in (shape.half_length, shape.half_width, shape.half_height)
    )
    return 1000 * volume_of(length, width, height, np.asarray(shape.rounding, np.float64) * r)


def volumes(table: Table) -> np.ndarray:
    """Return the volumes of a table's bodies as they are now [L]: f64[capacity]."""
    return litres(table[Body].radius, table[Shape] if Shape in table else None)


def newborn_volumes(table: Table, radius: Any) -> Any:
    """Return the volumes [L] of newborn with these radii [m] and the shape of their kind."""
    return litres(radius, SimpleNamespace(**table.defaults[Shape]) if Shape in table else None)


def bodies(table: Table) -> Bodies:
    """Return what the bodies of a table with Chemistry hold, its living and others, in the order of rows."""
    molarity = table[Chemistry].molarity
    if Matter in table:
        return Bodies(table[Matter].volume, molarity, table[Matter].residue)
    return Bodies(volumes(table), molarity, NO_RESIDUE)


class Books:
    """The ledger of matter of one world: the flows of each substance since a page was opened.

    `flows` f64[holders, substances, flows] [mol], positive into the holder: a table with Chemistry, or a
    field of a substance. `stock` f64[holders, substances] [mol] is what they held when the page was opened.
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
        """The holders by name, tables first."""
        return [name for _, name in self.holders]

    def book(
        self,
        holder: tuple[str, str],
        flow: str,
        amount: np.ndarray | float,
        substance: int | slice = slice(None),
    ) -> None:
        """Book an amount [mol] that goes into a holder: f64[substances], or that of one substance."""
        self.flows[self.holders[holder], substance, NUMBER[flow]] += amount

    def watch(self, world: SpatialWorld) -> None:
        """Book births and deaths of a world from now on."""
        self.world = weakref.proxy(world)
        world.on_birth.append(self.born)
        world.on_death.append(self.died)
        world.on_departure.append(lambda table, rows, to: self.moved(table, rows, "exported"))
        world.on_arrival.append(lambda table, rows, origin: self.moved(table, rows, "imported"))

    def moved(self, table: Table, rows: np.ndarray, flow: str) -> None:
        """Book what migrants hold, "imported" or "exported": rows i64[k]."""
        if ("table", table.name) in self.holders:
            sign = 1 if flow == "imported" else -1
            self.book(("table", table.name), flow, sign * total(rows, *bodies(table)))

    def born(self, table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        """Book what newborn hold: rows i64[k]. Of objects, those that have a parent are its remains."""
        if ("table", table.name) not in self.holders:
            return
        left = parents != 0 if table.species.is_object else np.zeros(rows.size, np.bool_)
        for flow, which in (("remains", rows[left]), ("endowed", rows[~left])):
            if which.size:
                self.book(("table", table.name), flow, total(which, *bodies(table)))

    def died(self, table: Table, rows: np.ndarray) -> None:
        """Book what the dying hold, before their rows are free: rows i64[k]. The eaten hold nothing any more,
        where their eaters took it."""
        if ("table", table.name) not in self.holders:
            return
        left = remaining(self.world, table, rows)
        if table.species.remains is None or ("table", table.species.remains) not in self.holders:
            left[:] = False
        for flow, which in (("remains", rows[left]), ("lost", rows[~left])):
            if which.size:
                self.book(("table", table.name), flow, -total(which, *bodies(table)))

    def turn(self, stock: np.ndarray) -> None:
        """Open a new page with these stocks."""
        self.stock = stock
        self.flows[...] = 0


def remaining(world: Any, table: Table, rows: np.ndarray) -> np.ndarray:
    """Return which of the dying leave their bodies behind: all but the eaten, and those that end by a cause
    of `world.bodiless`, bool[k]; rows i64[k]."""
    gone = np.zeros(256, np.bool_)  # of any code that a cause can have
    gone[: len(world.causes)] = [c.startswith("eaten") or c in world.bodiless for c in world.causes]
    return ~gone[table.cause[rows] - 1]


def stocks(world: SpatialWorld, books: Books) -> np.ndarray:
    """Return what each holder has of each substance now: f64[holders, substances] [mol]."""
    out = np.zeros(books.flows.shape[:2])
    for (kind, name), i in books.holders.items():
        if kind == "table":
            table = world.tables[name]
            out[i] = total(table.rows(), *bodies(table))
        else:
            field = world.fields[name]
            assert field.substance is not None
            out[i, world.substances.index(field.substance)] = field.held()
    return out


def book(world: SpatialWorld, table: Table, flow: str, amount: np.ndarray) -> None:
    """Book amounts f64[substances] [mol] that come into a table's bodies, in a world that keeps books."""
    if world.matter is not None:
        world.matter.book(("table", table.name), flow, amount)


def first_fields(world: SpatialWorld) -> dict[str, str]:
    """Return the first field of each substance that has one, by name."""
    return {
        field.substance: name for name, field in reversed(world.fields.items()) if field.substance is not None
    }


@contextmanager
def booked(world: SpatialWorld, table: Table, flow: str) -> Iterator[None]:
    """Book what the bodies of a table gain and lose within: for systems that change concentrations."""
    if world.matter is None:
        yield
        return
    rows = table.rows()
    before = total(rows, *bodies(table))
    yield
    book(world, table, flow, total(rows, *bodies(table)) - before)


def release(
    world: SpatialWorld, table: Table, amount: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray
) -> None:
    """Give amounts f64[k, substances] [mol] that have left bodies at places f32[k] to the first field of each
    substance; what has none is lost."""
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
    """Return the share that is gone after a tick, of what goes at a rate, 1 [1/tick]; f64[k] of f64[k]."""
    return -arrays.expm1(-rate) if isinstance(rate, np.ndarray) else -scalars.expm1(-rate)


@njit
def held(molarity, residue, row, s):
    """Return a concentration in float64."""
    rest = np.float64(residue[row, s]) if residue.size else 0.0
    return np.float64(molarity[row, s]) + rest


@njit
def hold(molarity, residue, row, s, value):
    """Set a concentration; return it as it is held now."""
    molarity[row, s] = np.float32(value)
    if residue.size:
        residue[row, s] = np.float32(value - np.float64(molarity[row, s]))
    return held(molarity, residue, row, s)


@njit
def total(rows, volume, molarity, residue):
    """Return what bodies hold of each substance: f64[substances] [mol]."""
    out = np.zeros(molarity.shape[1])
    for row in rows:
        for s in range(out.size):
            out[s] += held(molarity, residue, row, s) * volume[row]
    return out
