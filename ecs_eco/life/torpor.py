"""Torpor, for systems that skip torpid organisms."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Metabolism

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

NONE_LEFT = np.float32(0.0)
LEAST_ENERGY = {True: NONE_LEFT, False: np.float32(-np.inf)}
"""The minimum energy of organisms: True for species that fall into torpor, False for all others."""


def awake(table: Table) -> np.ndarray:
    """Return which rows are alive and not torpid: bool[capacity]; the mask `alive` itself if torpor is
    impossible."""
    if not table.species.metabolism.torpor:
        return table.alive
    return table.alive & (table[Metabolism].energy > NONE_LEFT)
