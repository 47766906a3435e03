"""A direction to wander in, for krill that hunt by a written reflex."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.engine import random

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

PERIOD = 12  # ticks that a whim lasts


def whim(world: SpatialWorld, table: Table, seekers: Any, out: np.ndarray, first: int) -> None:
    """Write two random numbers between 0 and 1 that each animal keeps for 12 ticks: its direction while it has no
    target."""
    uid = table.uid[seekers.rows]
    key = random.tick_key(world.seed, world.tick // PERIOD)
    for i in range(2):
        out[:, first + i] = random.draw_many(key, uid, random.WANDER + (i << 8))
