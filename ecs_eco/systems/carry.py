"""Animals carry objects, as ants carry seeds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Body, Carrier, Load, Metabolism, Position
from ecs_eco.engine.random import lots
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.engine.uids import matched
from ecs_eco.genomes.own_values import highest, own_value
from ecs_eco.life.torpor import LEAST_ENERGY, awake

if TYPE_CHECKING:
    from ecs_eco.compiled.per_row import Number
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Wishes(NamedTuple):
    """Animals of one table that could pick up objects of one type: rows i64[k] in both tables, and their
    distances."""

    table: Table
    thing: Table
    takers: np.ndarray
    objects: np.ndarray
    distance: np.ndarray


class Carry(System):
    """An animal that decides to `drop` puts down its object; an empty-handed animal that decides to `take`
    picks up the nearest object within reach that no animal carries.

    Across all species and objects, the nearest pairs have precedence; ties are broken at random. A carried
    object has its carrier's position and is dropped when the carrier dies. Carrying costs energy. An animal
    without these actions picks up any object it can and keeps it.
    """

    needs = (Position, Body, Metabolism, Load)
    phase = "move"
    submodel = Submodel(
        "Carrying",
        reads=("carries",),
        changes=("Load", "Carrier", "Metabolism.energy", "Metabolism.burnt", "Position"),
        draws="which of two equally near animals gets an object",
    )
    asked_for = staticmethod(lambda table: bool(table.species.carries))
    world: SpatialWorld

    def start(self, world: SpatialWorld) -> None:
        """Drop the objects carried by dying animals and by emigrants, which arrive empty-handed."""
        world.on_death.append(self.let_fall)
        world.on_departure.append(lambda table, rows, to: self.let_fall(table, rows))
        world.on_arrival.append(lambda table, rows, origin: put_down(table, rows))

    def process(self, *_args: object) -> None:
        """Put down, pick up and carry objects, for all species."""
        self._hands: list[tuple[Table, list[Table], np.ndarray]] = []
        super().process()
        wishes = [
            reachable(table, thing, own_value(table, f"carries.{number}.reach", way.reach), empty, self.world)
            for table, things, empty in self._hands
            if empty.any()
            for number, (way, thing) in enumerate(zip(table.species.carries, things, strict=True))
            if thing.n
        ]
        hand_out(self.world.key, wishes)
        for table, things, _ in self._hands:
            self.carry(table, things, self.world)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Put down the objects that one species drops, and record which animals are empty-handed."""
        load, species = table[Load], table.species
        things = [world.tables[way.object] for way in species.carries]
        rows = table.by_uid()
        held = where(things, load.object[rows])
        gone = rows[(load.object[rows] != 0) & (held[:, 0] < 0)]
        put_down(table, gone)
        dropping = rows[does(table, "drop", False)[rows] & (load.object[rows] != 0)]
        for kind, thing in where(things, load.object[dropping]):
            things[kind][Carrier].uid[thing] = 0
        put_down(table, dropping)
        empty = (load.object == 0) & awake(table) & (table.cause == 0) & does(table, "take", True)
        empty[dropping] = False
        self._hands.append((table, things, empty))

    def carry(self, table: Table, things: list[Table], world: SpatialWorld) -> None:
        """Move carried objects to their carriers, and charge the carriers."""
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
            least = LEAST_ENERGY[table.species.metabolism.torpor]
            m.energy[carriers] = np.maximum(after, np.minimum(before, least))
            m.burnt[carriers] += before - m.energy[carriers]

    def let_fall(self, table: Table, rows: np.ndarray) -> None:
        """Release the objects that dying animals carry; rows i64[k] are in uid order."""
        if Load in table:
            things = [self.world.tables[way.object] for way in table.species.carries]
            for kind, thing in where(things, table[Load].object[rows]):
                if kind >= 0:
                    things[kind][Carrier].uid[thing] = 0


def put_down(table: Table, rows: np.ndarray) -> None:
    """Make the animals in rows i64[k] empty-handed."""
    if Load in table:
        table[Load].object[rows], table[Load].mass[rows] = 0, 0


def where(things: list[Table], uids: np.ndarray) -> np.ndarray:
    """For uids u64[k], return the index of the table among `things` and the row, i64[k, 2]; −1 if not found."""
    out = np.full((uids.size, 2), -1, np.int64)
    for number, thing in enumerate(things):
        rows = thing.by_uid()
        at, same = matched(thing.uid[rows], uids)
        out[same, 0], out[same, 1] = number, rows[at[same]]
    return out


def does(table: Table, action: str, otherwise: bool) -> np.ndarray:
    """Return which animals execute an action of the group `carry`, bool[capacity]; in a species without this
    group, all living animals do so if `otherwise` is true."""
    nerves: Any = table.species.nerves
    if nerves is None or "carry" not in nerves.groups:
        return table.alive & otherwise
    if action not in nerves.groups["carry"]:
        return np.zeros(table.capacity, np.bool_)
    done: np.ndarray = nerves.doing(table, f"carry.{action}")
    return done


def reachable(table: Table, thing: Table, reach: Number, empty: np.ndarray, world: SpatialWorld) -> Wishes:
    """Return the pairs of an empty-handed animal (`empty` bool[capacity]) and an object of one type within
    reach; `reach` [m] is a number or f64[high]."""
    mine, theirs = table[Body].radius, thing[Body].radius
    widest = float(mine[table.rows()].max() + theirs[thing.rows()].max()) + highest(reach, table.alive)
    takers, objects, distance = world.pairs(table, thing, max(np.nextafter(np.float32(widest), np.inf), 1e-6))
    each = np.float32(reach[takers] if isinstance(reach, np.ndarray) else reach)
    near = (
        (distance <= mine[takers] + theirs[objects] + each)
        & empty[takers]
        & (thing[Carrier].uid[objects] == 0)
        & (thing.cause[objects] == 0)
    )
    return Wishes(table, thing, takers[near], objects[near], distance[near])


def hand_out(key: np.uint64, wishes: list[Wishes]) -> None:
    """Give each object to the nearest animal of any species that is still empty-handed; break ties at random."""
    if not wishes:
        return
    uid = np.concatenate([w.table.uid[w.takers] for w in wishes])
    object_uid = np.concatenate([w.thing.uid[w.objects] for w in wishes])
    order = np.lexsort((lots(key, uid, object_uid), np.concatenate([w.distance for w in wishes])))
    given = np.zeros(uid.size, np.bool_)
    given[order] = first_come(*(np.unique(uids, return_inverse=True)[1][order] for uids in (uid, object_uid)))
    ends = np.cumsum([w.takers.size for w in wishes])
    for w, got in zip(wishes, np.split(given, ends[:-1]), strict=True):
        rows, objects = w.takers[got], w.objects[got]
        load = w.table[Load]
        load.object[rows], load.mass[rows] = w.thing.uid[objects], w.thing[Body].mass[objects]
        w.thing[Carrier].uid[objects] = w.table.uid[rows]


@njit
def first_come(who, what):
    """Return which pairs are accepted when they are processed in order and each member is used at most once."""
    out, has, gone = np.zeros(who.size, np.bool_), np.zeros(who.size, np.bool_), np.zeros(who.size, np.bool_)
    for i in range(who.size):
        if not has[who[i]] and not gone[what[i]]:
            out[i], has[who[i]], gone[what[i]] = True, True, True
    return out
