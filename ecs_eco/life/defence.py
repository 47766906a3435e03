"""The cost of plant defense, for the systems that charge it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Defence
from ecs_eco.genomes.own_values import own_value

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


def left_by_defence(table: Table, high: int) -> np.ndarray | np.float32:
    """Return the share of growth and of sprouting seeds that remains after paying for defense: f32[high], or
    a single number for all."""
    defence = table.species.defence
    if defence.cost == 0 and not table.species.traits:
        return np.float32(1.0)
    cost = own_value(table, "defence.cost", np.float32(defence.cost))
    if isinstance(cost, np.ndarray):
        spent = (
            table[Defence].toughness[:high] + table[Defence].poison[:high]
            if Defence in table
            else np.float32(defence.toughness + defence.poison)
        )
        return np.maximum(np.float32(1) - cost * spent, np.float32(0))
    if defence.cost == 0:
        return np.float32(1.0)
    if Defence not in table:
        return np.float32(max(0.0, 1 - defence.cost * (defence.toughness + defence.poison)))
    own = table[Defence]
    return np.maximum(
        np.float32(1) - np.float32(defence.cost) * (own.toughness[:high] + own.poison[:high]), np.float32(0)
    )
