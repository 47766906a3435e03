"""Organisms die when a property leaves the interval in which they can live."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Biology, LifeHistory, Nervous
from ecs_eco.config.numbers import labels
from ecs_eco.engine.jit import lone_njit
from ecs_eco.engine.per_row import of_row
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_value, own_values
from ecs_eco.lifecycle.causes import register_limits
from ecs_eco.nervous.sensors.own import own_column
from ecs_eco.space.world import SpatialWorld

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


class Perish(System):
    """Too cold, too acid, too old, starved: each end of each interval is a separate cause of death.

    Death has a reward: the minimum of happiness minus the happiness last felt.
    """

    phase = "die"
    world: SpatialWorld

    def start(self, world: SpatialWorld) -> None:
        """Register the causes of death in the order of species."""
        for table in world.tables.values():
            register_limits(world, table)
        world.on_death.append(self.mourn)

    def process(self, *_: Any) -> None:
        """Mark those beyond a limit."""
        codes = self.world.codes
        for table in self.world.tables.values():
            names = labels(table.species.lethal) if table.species.traits else []
            for i, limit in enumerate(table.species.lethal):
                low, high = limit.min, limit.max
                column = own_column(table, limit.property, self.world.substances)
                if limit.property == "age" and high is not None and LifeHistory in table:
                    # the limit is individual
                    column, high = table[Biology].age - table[LifeHistory].age_max, 0.0
                    low = None
                ends = (np.float32(-np.inf if low is None else low),
                        np.float32(np.inf if high is None else high))
                if names:
                    ends = own_values(table, {f"lethal.{names[i]}.min": ends[0],
                                              f"lethal.{names[i]}.max": ends[1]})
                perish(table.alive[: table.high], column, *ends,
                       0 if low is None else codes[limit.low],
                       0 if high is None else codes[limit.high], table.cause)

    def mourn(self, table: Table, rows: np.ndarray) -> None:
        """Give the dying of one species their last reward, whatever they die of;
        rows i64[k] in the order of uids."""
        nerves = table.species.nerves
        if nerves is None or nerves.happiness is None:
            return
        n = table[Nervous]
        least: Any = nerves.minimum
        if table.species.traits:
            least = own_value(table, "happiness.minimum", least)
        n.reward[rows] = (least[rows] if isinstance(least, np.ndarray) else least) - n.happiness[rows]
        if nerves.learning:
            nerves.end(rows, n.reward[rows])


@lone_njit
def perish(alive, value, low, high, too_low, too_high, cause):
    """Mark the living whose value is at or beyond a limit; those already dying keep the first cause. Without
    branches, so that it becomes vector code."""
    none, below, above = np.uint8(0), np.uint8(too_low), np.uint8(too_high)
    for k in range(alive.size):
        row = np.uint64(k)
        here, before = value[row], cause[row]
        after = below if here <= of_row(low, row) else (above if here >= of_row(high, row) else none)
        cause[row] = after if alive[row] & (before == none) else before
