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
    from ecs_eco.compiled.per_row import Number
    from ecs_eco.config.features.building import Build as Way
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

TURN = random.LOT + (2 << 8)  # purpose of the draws that decide which animal builds first


class Build(System):
    """An animal that decides to build and has more energy than the cost builds an object, such as a nest, a
    dam or a honey store, at its position.

    The animal pays the cost, and the object receives the energy defined for its type. New objects respect the
    minimum spacing and the maximum number; if too many animals want to build, random draws decide which of
    them do. The objects appear at the end of the tick.
    """

    needs = (Position, Body, Metabolism)
    phase = "interact"
    submodel = Submodel(
        "Building",
        reads=("builds",),
        changes=("Metabolism.energy", "Metabolism.burnt"),
        draws="which animals build if too many want to",
    )
    asked_for = staticmethod(lambda table: bool(table.species.builds))

    def competes(self, table: Table) -> bool:
        """Return whether a species builds objects."""
        return bool(table.species.builds)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Build objects for one species."""
        for number, way in enumerate(table.species.builds):
            cost, spacing = own_values(
                table,
                {f"builds.{number}.cost": np.float32(way.cost), f"builds.{number}.spacing": way.spacing},
            )
            self.build(table, world.tables[way.object], way, world, cost, spacing)

    def build(
        self, table: Table, thing: Table, way: Way, world: SpatialWorld, cost: Number, spacing: Number
    ) -> None:
        """Build objects of one type for one species; cost and spacing are numbers or arrays [high]."""
        m, p, nerves = table[Metabolism], table[Position], table.species.nerves
        worth = np.float32(0.0 if thing.species.energy is None else thing.species.energy.initial)
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
        rows = rows[random.by_lot(world.key, table.uid[rows], TURN)]
        apart = np.broadcast_to(spacing, table.high)[rows]
        if rows.size and apart.max() > 0:
            rows = rows[free(thing, np.stack([p.x[rows], p.y[rows], p.z[rows]], 1), apart, world)]
        if way.most is not None:
            rows = rows[: max(0, way.most - thing.n - thing.waiting)]
        if not rows.size:
            return
        rows = rows[table.uid[rows].argsort()]
        thing.request(
            table.uid[rows], {(Position, axis): getattr(p, axis)[rows] for axis in ("x", "y", "z", "heading")}
        )
        before = m.energy[rows]
        m.energy[rows] = before - price[rows]
        m.given[rows] += worth
        m.burnt[rows] += before - m.energy[rows] - worth


def free(thing: Table, places: np.ndarray, spacing: np.ndarray, world: SpatialWorld) -> np.ndarray:
    """Return whether each position f32[k, 3] [m] is at least `spacing` f64[k] [m] from all existing and
    requested objects of a type and from previously accepted positions: bool[k]."""
    out = np.ones(len(places), np.bool_)
    if thing.n:
        out[world.within(thing, places[:, : len(world.space.size)], spacing).rows] = False
    asked = [
        np.stack([values[Position, axis] for axis in "xyz"], 1)
        for _, _, values in thing.births
        if (Position, "x") in values
    ]
    before = np.concatenate([np.zeros((0, 3), np.float32), *asked]).astype(np.float32)
    keep_apart(places, before, spacing.astype(np.float32), world.space.extent, out)
    return out


@njit
def keep_apart(
    places: np.ndarray, before: np.ndarray, spacing: np.ndarray, space: Extent, out: np.ndarray
) -> None:
    """Clear `out` for positions closer than `spacing` to a position in `before` or to an accepted position."""
    for i in range(len(places)):
        for j in range(len(before) + i):
            if out[i] and (j < len(before) or out[j - len(before)]):
                other = before[j] if j < len(before) else places[j - len(before)]
                x, y, z = places[i, 0], places[i, 1], places[i, 2]
                dx, dy, dz = offset(x, y, z, other[0], other[1], other[2], space)
                if dx * dx + dy * dy + dz * dz < spacing[i] * spacing[i]:
                    out[i] = False
