"""Torpor, for the systems in which the torpid take no part."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Metabolism

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

NONE_LEFT, NO_LIMIT = np.float32(0.0), np.float32(-np.inf)


def least_energy(table: Table) -> np.float32:
    """Return the energy below which the organisms of a table cannot fall: 0 of those that fall into torpor,
    −∞ of others."""
    return NONE_LEFT if table.species.torpor else NO_LIMIT


def awake(table: Table) -> np.ndarray:
    """Return which rows live and are not torpid: bool[capacity]; the mask `alive` itself where none can be.
    """
    if not table.species.torpor:
        return table.alive
    return table.alive & (table[Metabolism].energy > NONE_LEFT)
