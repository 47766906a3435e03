"""Effects of the surroundings on bodies, for several systems."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Physical, Position

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def temperatures(table: Table, world: SpatialWorld) -> np.ndarray:
    """Return the temperatures f32[high] [K] of bodies, or of their surroundings if bodies have none."""
    p, high = table[Position], table.high
    if "temperature" in table.species.properties:
        own: np.ndarray = table[Physical].temperature[:high]
        return own
    around = world.surroundings("temperature", p.x[:high], p.y[:high], p.z[:high])
    return around.astype(np.float32, copy=False)
