"""Ants carry seeds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Body, Carrier, Load, Metabolism, Position
from ecs_eco.engine.jit import njit
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import highest, own_value
from ecs_eco.lifecycle.torpor import LEAST_ENERGY, awake

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Carry(System):
    """An animal puts down what it carries if it decides to `drop`; one that carries nothing and decides to
    `take` picks up the nearest object in reach that nobody carries.

    Nearer pairs go first, ties to the lower uid of the animal, then of the object. What is carried is where
    its carrier is, and falls where that dies. Carrying has a cost. An animal without these actions takes
    whatever it can and keeps it.
    """

    needs = (Position, Body, Metabolism, Load)
    phase = "move"

    def start(self, world: SpatialWorld) -> None:
        """Let what the dying carry fall, and what those carry that leave for another island."""
        world.on_death.append(self.let_fall)
        world.on_departure.append(lambda table, rows, to: self.let_fall(table, rows))

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Let one species put down, pick up and carry."""
        load, species = table[Load], table.species
        things = [world.tables[way.object] for way in species.carries]
        rows = table.by_uid()
        held = where(things, load.object[rows])
        gone = rows[(load.object[rows] != 0) & (held[:, 0] < 0)]
        load.object[gone], load.mass[gone] = 0, 0
        dropping = rows[does(table, "drop", False)[rows] & (load.object[rows] != 0)]
        for kind, thing in where(things, load.object[dropping]):
            things[kind][Carrier].uid[thing] = 0
        load.object[dropping], load.mass[dropping] = 0, 0
        empty = (load.object == 0) & awake(table) & (table.cause == 0) & does(table, "take", True)
        empty[dropping] = False
        for number, (way, thing) in enumerate(zip(species.carries, things, strict=True)):
            take(table, thing, own_value(table, f"carries.{number}.reach", way.reach), empty, world)
        self.carry(table, things, world)

    def carry(self, table: Table, things: list[Table], world: SpatialWorld) -> None:
        """Bring what is carried to its carriers, who pay for it."""
        load, p, m, rows = table[Load], table[Position], table[Metabolism], table.by_uid()
        held = where(things, load.object[rows])
        for number, (way, thing) in enumerate(zip(table.species.carries, things, strict=True)):
            mine = held[:, 0] == number
            carriers, objects, to = rows[mine], held[mine, 1], thing[Position]
            for axis in ("x", "y", "z", "heading"):
                getattr(to, axis)[objects] = getattr(p, axis)[carriers]
            if carriers.size:
                thing.version += 1
            before = m.energy[carriers]
            cost = own_value(table, f"carries.{number}.cost", way.cost) * world.dt
            after = before - np.float32(cost[carriers] if isinstance(cost, np.ndarray) else cost)
            m.energy[carriers] = np.maximum(after, np.minimum(before, LEAST_ENERGY[table.species.torpor]))
            m.burnt[carriers] += before - m.energy[carriers]

    def let_fall(self, table: Table, rows: np.ndarray) -> None:
        """Free the objects that the dying carry; rows i64[k] in the order of uids."""
        if Load in table:
            things = [self.world.tables[way.object] for way in table.species.carries]
            for kind, thing in where(things, table[Load].object[rows]):
                if kind >= 0:
                    things[kind][Carrier].uid[thing] = 0


def where(things: list[Table], uids: np.ndarray) -> np.ndarray:
    """Return the number of the table among `things` and the row of each uid u64[k]: i64[k, 2]; −1 where there
    is none."""
    out = np.full((uids.size, 2), -1, np.int64)
    for number, thing in enumerate(things):
        rows = thing.by_uid()
        if rows.size:
            at = np.minimum(np.searchsorted(thing.uid[rows], uids), rows.size - 1)
            same = thing.uid[rows[at]] == uids
            out[same, 0], out[same, 1] = number, rows[at[same]]
    return out


def does(table: Table, action: str, otherwise: bool) -> np.ndarray:
    """Return who does an action of the group `carry`: bool[capacity]; `otherwise` for all where a species has
    none of them."""
    nerves: Any = table.species.nerves
    if nerves is None or "carry" not in nerves.groups:
        return table.alive & otherwise
    if action not in nerves.groups["carry"]:
        return np.zeros(table.capacity, np.bool_)
    done: np.ndarray = nerves.doing(table, f"carry.{action}")
    return done


def take(table: Table, thing: Table, reach: Any, empty: np.ndarray, world: SpatialWorld) -> None:
    """Let those with empty hands (bool[capacity], changed) pick up objects of one type within `reach` [m], or
    each within its own f64[high]."""
    if not empty.any() or not thing.n:
        return
    mine, theirs = table[Body].radius, thing[Body].radius
    widest = float(mine[table.rows()].max() + theirs[thing.rows()].max()) + highest(reach, table.alive)
    takers, objects, distance = world.pairs(table, thing, max(np.nextafter(np.float32(widest), np.inf), 1e-6))
    each = np.float32(reach[takers] if isinstance(reach, np.ndarray) else reach)
    near = ((distance <= mine[takers] + theirs[objects] + each) & empty[takers]
            & (thing[Carrier].uid[objects] == 0) & (thing.cause[objects] == 0))
    takers, objects, distance = takers[near], objects[near], distance[near]
    order = np.lexsort((thing.uid[objects], table.uid[takers], distance))
    hand_out(takers[order], objects[order], table.uid, thing.uid, thing[Body].mass, empty, table[Load].object,
             table[Load].mass, thing[Carrier].uid)


@njit
def hand_out(takers, objects, uid, object_uid, mass, empty, load, load_mass, carrier):
    """Give each object to the first that wants it, one to each."""
    for i in range(takers.size):
        row, thing = takers[i], objects[i]
        if empty[row] and carrier[thing] == 0:
            empty[row] = False
            load[row] = object_uid[thing]
            load_mass[row] = mass[thing]
            carrier[thing] = uid[row]
