"""What krill that hunt by a written reflex wander by."""

from typing import Any

import numpy as np

from ecs_eco.engine import random

PERIOD = 12  # ticks that a whim lasts


def whim(world: Any, table: Any, seekers: Any, out: np.ndarray, first: int) -> None:
    """Write two numbers between 0 and 1 that each animal keeps for some ticks: where to, while it has no aim."""
    uid = table.uid[seekers.rows]
    key = random.tick_key(world.seed, world.tick // PERIOD)
    for i in range(2):
        out[:, first + i] = random.draw_many(key, uid, random.WANDER + (i << 8))
