"""Remains release their substances."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import scalars
from ecs_eco.compiled.jit import njit
from ecs_eco.components import Chemistry, Matter, Position
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.life.matter import Bodies, bodies, held, hold, release

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

CAUSE, ROTTED = "decomposed", "decayed"  # ROTTED: lost its energy


class Decompose(System):
    """A carcass releases a share of its substances in each tick (Olson 1963), which returns nutrients to the
    soil. When little is left, it releases the rest and vanishes."""

    needs = (Position, Chemistry, Matter)
    phase = "metabolise"
    submodel = Submodel(
        "Decomposition",
        reads=("decomposition",),
        rules={"": "`dc/dt = −rate c` for each substance c, which enters the first field of this substance."},
        changes=("Chemistry", "Matter"),
    )
    asked_for = staticmethod(lambda table: table.species.decomposition is not None)
    world: SpatialWorld

    def start(self, world: SpatialWorld) -> None:
        """Register the cause of death, and watch for objects that vanish after losing their energy."""
        world.cause(CAUSE)
        world.on_death.append(self.vanish)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Decompose one type of object."""
        way = table.species.decomposition
        if way is None or not table.n:
            return
        rows, p = world.index(table).rows, table[Position]
        # nothing decays in its tick of birth, because births follow this system
        last = math.ceil(-scalars.log(way.left) / (way.rate * world.dt))
        old = world.tick - table.born[rows] >= last
        amount = np.zeros((rows.size, len(world.substances)))
        give_back(rows, old, -scalars.expm1(-way.rate * world.dt), bodies(table), amount)
        release(world, table, amount, p.x[rows], p.y[rows], p.z[rows])
        ends = rows[old]
        table.cause[ends[table.cause[ends] == 0]] = world.cause(CAUSE)

    def vanish(self, table: Table, rows: np.ndarray) -> None:
        """Release all substances of decayed objects; rows i64[k] are in uid order."""
        if table.species.decomposition is None or Matter not in table or ROTTED not in self.world.causes:
            return
        rows, p = rows[table.cause[rows] == self.world.cause(ROTTED)], table[Position]
        amount = np.zeros((rows.size, len(self.world.substances)))
        give_back(rows, np.ones(rows.size, np.bool_), 1.0, bodies(table), amount)
        release(self.world, table, amount, p.x[rows], p.y[rows], p.z[rows])


@njit
def give_back(rows: np.ndarray, old: np.ndarray, share: float, bodies: Bodies, amount: np.ndarray) -> None:
    """Remove a share of every substance from bodies, or all of it from old bodies, and write the amounts to
    `amount` f64[n, substances] [mol]."""
    for i in range(rows.size):
        row = rows[i]
        for s in range(bodies.molarity.shape[1]):
            c = held(bodies, row, s)
            left = 0.0 if old[i] else c * (1 - share)
            amount[i, s] = (c - hold(bodies, row, s, left)) * bodies.volume[row]
