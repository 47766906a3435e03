"""Animals build."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Body, Metabolism, Position
from ecs_eco.engine import random
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_values
from ecs_eco.life.torpor import awake
from ecs_eco.space.geometry import Extent
from ecs_eco.space.sight import offset

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

TURN = random.LOT + (2 << 8)  # purpose of the draws that decide which animal builds first


class Build(System):
    """An animal that decides to build and has more energy than the cost builds an object, such as a nest, a
    dam or a honey store, at its position.

    The animal pays the cost, and the object receives the energy defined for its type. New objects respect the
    minimum spacing and the maximum number: the animals of all species build in random order, one type of
    object after the other, and those that find the maximum number reached are counted as refused. The objects
    appear at the end of the tick.
    """

    needs = (Position, Body, Metabolism)
    world: SpatialWorld
    phase = "interact"
    submodel = Submodel(
        "Building",
        reads=("builds",),
        changes=("Metabolism.energy", "Metabolism.burnt"),
        draws="the order in which the animals of all species build",
    )
    asked_for = staticmethod(lambda table: bool(table.species.builds))

    def process(self, *_: object) -> None:
        """Build objects of each type, for all species."""
        self._builders: dict[str, list[tuple[Table, int]]] = {}
        super().process()
        for name, builders in self._builders.items():
            build(self.world, self.world.tables[name], builders)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Note which objects a species builds."""
        for number, way in enumerate(table.species.builds):
            self._builders.setdefault(way.object, []).append((table, number))


def build(world: SpatialWorld, thing: Table, builders: list[tuple[Table, int]]) -> None:
    """Build objects of one type, for all species that build them: tables, and numbers of the ways to build."""
    worth = np.float32(0.0 if thing.species.energy is None else thing.species.energy.initial)
    wishes = [wanted(table, number, worth) for table, number in builders]
    uid, place, apart, most, _, _ = map(np.concatenate, zip(*wishes, strict=True))
    order, built = random.by_lot(world.key, uid, TURN), np.empty(uid.size, np.bool_)
    left = most[order] - thing.n - thing.waiting
    built[order], refused = free(thing, place[order], apart[order], left, world)
    thing.species.refused += refused
    ends = np.cumsum([len(wish[0]) for wish in wishes])[:-1]
    for (table, _), (*_, rows, price), done in zip(builders, wishes, np.split(built, ends), strict=True):
        rows, price, m, p = rows[done], price[done], table[Metabolism], table[Position]
        thing.request(
            table.uid[rows], {(Position, axis): getattr(p, axis)[rows] for axis in ("x", "y", "z", "heading")}
        )
        before = m.energy[rows]
        m.energy[rows] = before - price
        m.given[rows] += worth
        m.burnt[rows] += before - m.energy[rows] - worth


def wanted(table: Table, number: int, worth: np.float32) -> tuple[np.ndarray, ...]:
    """Return the animals that want to build an object that holds the energy `worth`, sorted by uid: uid,
    position [m], spacing [m], maximum number of objects, row, price."""
    m, p, nerves, way = table[Metabolism], table[Position], table.species.nerves, table.species.builds[number]
    cost, spacing = own_values(
        table, {f"builds.{number}.cost": np.float32(way.cost), f"builds.{number}.spacing": way.spacing}
    )
    price = np.broadcast_to(cost + worth, table.high)
    wants = (awake(table) & (table.cause == 0))[: table.high]
    wants &= (m.energy[: table.high] > price) | (price == 0)
    if nerves is not None and "build" in nerves.groups:
        wants &= (
            nerves.doing(table, f"build.{way.object}")[: table.high]
            if way.object in nerves.groups["build"]
            else False
        )
    rows = np.flatnonzero(wants)
    rows = rows[table.uid[rows].argsort()]
    place, most = np.stack([p.x[rows], p.y[rows], p.z[rows]], 1), np.inf if way.most is None else way.most
    apart = np.broadcast_to(spacing, table.high)[rows]
    return table.uid[rows], place, apart, np.full(rows.size, float(most)), rows, price[rows]


def free(
    thing: Table, places: np.ndarray, spacing: np.ndarray, left: np.ndarray, world: SpatialWorld
) -> tuple[np.ndarray, int]:
    """Return whether an object of a type fits at each position f32[k, 3] [m]: bool[k]. It must be at least
    `spacing` f64[k] [m] from all existing, requested and previously accepted ones, of which there may be
    fewer than `left` f64[k]. Return also how many only `left` prevents."""
    out = np.ones(len(places), np.bool_)
    if thing.n and spacing.any():
        out[world.within(thing, places[:, : len(world.space.size)], spacing).rows] = False
    asked = [
        np.stack([values[Position, axis] for axis in "xyz"], 1)
        for _, _, values in thing.births
        if (Position, "x") in values
    ]
    before = np.concatenate([np.zeros((0, 3), np.float32), *asked]).astype(np.float32)
    return out, accept(places, before, spacing.astype(np.float32), left, world.space.extent, out)


@njit
def accept(
    places: np.ndarray,
    before: np.ndarray,
    spacing: np.ndarray,
    left: np.ndarray,
    space: Extent,
    out: np.ndarray,
) -> int:
    """Clear `out` for positions closer than `spacing` to a position in `before` or to an accepted position,
    and for those after `left` accepted ones; return how many only the latter prevents."""
    n = refused = 0
    for i in range(len(places)):
        for j in range(len(before) + i if spacing[i] > 0 else 0):
            if out[i] and (j < len(before) or out[j - len(before)]):
                other = before[j] if j < len(before) else places[j - len(before)]
                x, y, z = places[i, 0], places[i, 1], places[i, 2]
                dx, dy, dz = offset(x, y, z, other[0], other[1], other[2], space)
                if dx * dx + dy * dy + dz * dz < spacing[i] * spacing[i]:
                    out[i] = False
        if out[i]:
            out[i] = n < left[i]
            n, refused = n + out[i], refused + 1 - out[i]
    return refused
