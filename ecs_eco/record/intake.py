"""Energy gained by each species from each food in each tick: columns of the series, and their sums."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.config.models.reporters import EATEN

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld


class Intake:
    """Energy that each species gained from each food, in each tick of a block: f64[ticks, species, foods].

    It is part of the energy taken in; the rest came from light, from parents, or from reactions. `total` is
    the sum over all ticks, and `flows` the sum of the ledger, f64[species, columns], written by `add_up`: a
    recording that continues from a checkpoint starts both at 0.
    """

    def __init__(self, world: SpatialWorld, names: list[str], block: int, columns: int) -> None:
        tables = [world.tables[name] for name in names]
        self.foods = list(dict.fromkeys(food.eats for table in tables for food in table.species.foods))
        self._places = [
            (s, self.foods.index(food.eats), food.eats, table)
            for s, table in enumerate(tables)
            for food in table.species.foods
        ]
        self.eaters = {s for s, *_ in self._places}
        self.values = np.zeros((block, len(names), len(self.foods)))
        self.total = np.zeros((len(names), len(self.foods)))
        self.flows = np.zeros((len(names), columns))

    def gained(self, at: int) -> np.ndarray:
        """Return the energy gained in the tick that has just passed, f64[species, foods], and store it."""
        row = self.values[at]
        for s, k, food, table in self._places:
            row[s, k] = table.species.eaten.get(food, 0.0)
        return row

    def columns(self, n: int) -> dict[str, np.ndarray]:
        """Return copies of the first n ticks as flat columns, by tick, then species."""
        return {EATEN + food: self.values[:n, :, k].flatten() for k, food in enumerate(self.foods)}
