"""Transfer of substances from eaten organisms to their eaters."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Chemistry, Matter, Position
from ecs_eco.life.matter import Bodies, bodies, book, held, hold, release

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def swallow(
    world: SpatialWorld,
    table: Table,
    eaters: np.ndarray,
    prey: Table,
    eaten: np.ndarray,
    share: float | np.ndarray,
) -> None:
    """Move the substances of eaten organisms (rows i64[k]) into their eaters (rows i64[k], in canonical
    order).

    The assimilated share, a number or one per row of the eaters' table, is added to the content of the
    eater's body; the rest enters the fields at the eater's position.
    """
    if not eaten.size or Matter not in table or Chemistry not in prey:
        return
    left = np.zeros((eaten.size, len(world.substances)))
    taken = ingest(eaters, eaten, share, bodies(table), bodies(prey), left)
    book(world, prey, "eaten", -taken)
    book(world, table, "eaten", taken)
    p = table[Position]
    release(world, table, left, p.x[eaters], p.y[eaters], p.z[eaters])


@njit
def ingest(
    eaters: np.ndarray, eaten: np.ndarray, share: Number, bodies: Bodies, foods: Bodies, left: np.ndarray
) -> np.ndarray:
    """Empty the eaten organisms, add the assimilated share of their substances to their eaters, and write the
    rest to `left` f64[k, substances] [mol]; return the amounts eaten f64[substances] [mol]."""
    taken, volume = np.zeros(bodies.molarity.shape[1]), bodies.volume
    for i in range(eaten.size):
        row, food = eaters[i], eaten[i]
        for s in range(taken.size):
            amount = held(foods, food, s) * foods.volume[food]
            hold(foods, food, s, 0.0)
            before = held(bodies, row, s)
            now = hold(bodies, row, s, before + of_row(share, row) * amount / volume[row])
            taken[s] += amount
            left[i, s] = amount - (now - before) * volume[row]
    return taken
