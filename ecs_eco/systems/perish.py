"""Organisms die when a property leaves the range in which they can live."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import lone_njit
from ecs_eco.compiled.per_row import of_row
from ecs_eco.components import Biology, LifeHistory, Nervous
from ecs_eco.config.numbers import labels
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_values
from ecs_eco.life.causes import register_limits
from ecs_eco.nervous.networks import last_reward
from ecs_eco.nervous.sensors.own import own_column
from ecs_eco.space.world import SpatialWorld

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


class Perish(System):
    """An organism dies when one of its properties leaves the range in which it can live. Each end of each
    range is a separate cause of death.

    The reward at death is the minimum happiness minus the last happiness value.
    """

    phase = "die"
    divisible = True
    submodel = Submodel(
        "Death",
        where=("lethal",),
        reads=("lethal",),
        rules={
            "": "An individual dies in the tick in which a property is at or below `min`, or at or above "
            "`max`."
        },
    )
    world: SpatialWorld

    def start(self, world: SpatialWorld) -> None:
        """Register the causes of death, species by species."""
        for table in world.tables.values():
            register_limits(world, table)
        world.on_death.append(self.mourn)

    def process(self, *_: object) -> None:
        """Mark organisms beyond a limit."""
        for table in self.world.tables.values():
            self.check(table)

    def check(self, table: Table) -> None:
        """Mark organisms of one species beyond a limit."""
        codes = self.world.codes
        names = labels(table.species.lethal) if table.species.traits else []
        for i, limit in enumerate(table.species.lethal):
            low, high = limit.min, limit.max
            column = own_column(table, limit.property, self.world.substances)
            if limit.property == "age" and high is not None and LifeHistory in table:
                # the limit is individual
                column, high = table[Biology].age - table[LifeHistory].age_max, 0.0
                low = None
            ends = ends_of(low, high)
            if names:
                ends = own_values(
                    table, {f"lethal.{names[i]}.min": ends[0], f"lethal.{names[i]}.max": ends[1]}
                )
            perish(
                table.alive[: table.high],
                column,
                *ends,
                0 if low is None else codes[limit.cause_below],
                0 if high is None else codes[limit.cause_above],
                table.cause,
            )

    def mourn(self, table: Table, rows: np.ndarray) -> None:
        """Give dying organisms of one species the reward for death, whatever the cause, in addition to this
        tick's reward; rows i64[k] are in uid order."""
        nerves = table.species.nerves
        if nerves is None or nerves.happiness is None:
            return
        last = last_reward(table, rows)
        table[Nervous].reward[rows] += last
        if nerves.learning:
            nerves.end(rows, last)


def ends_of(low: float | None, high: float | None) -> tuple[np.float32, np.float32]:
    """Return the ends of an interval; open ends are infinite."""
    return np.float32(-np.inf if low is None else low), np.float32(np.inf if high is None else high)


@lone_njit
def perish(alive, value, low, high, too_low, too_high, cause):
    """Mark living organisms whose value is at or beyond a limit; organisms already dying keep their first
    cause. Branch-free, so that it vectorizes."""
    none, below, above = np.uint8(0), np.uint8(too_low), np.uint8(too_high)
    for k in range(alive.size):
        row = np.uint64(k)
        here, before = value[row], cause[row]
        after = below if here <= of_row(low, row) else (above if here >= of_row(high, row) else none)
        cause[row] = after if alive[row] & (before == none) else before
