"""Eggs develop and hatch."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Incubation, Metabolism, Parentage, Physical, Position
from ecs_eco.engine.jit import njit
from ecs_eco.engine.system import System
from ecs_eco.lifecycle.eggs import hatch

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

HATCHED = "hatched"  # the cause of the end of an egg


class Hatch(System):
    """An egg develops, faster where it is warmer, and hatches at the end of its incubation: the egg ends, and
    a newborn with its energy, genome and parents takes its place.

    The rate is proportional to the degrees above a threshold (degree-days, Réaumur 1735), of the egg itself
    if it has a temperature, else of its place. Eaten eggs do not hatch, and nobody hatches while policies are
    pre-trained.
    """

    needs = (Position, Metabolism, Parentage, Incubation)
    phase = "die"
    asked_for = staticmethod(lambda table: table.species.hatch is not None)

    def start(self, world: SpatialWorld) -> None:
        """Register the cause of their end."""
        world.cause(HATCHED)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Let the eggs of one species develop, and those that are ripe hatch."""
        way = table.species.hatch
        if way is None or not table.n or not world.reproduction:
            return
        high, developed = table.high, table[Incubation].developed
        world.split(
            develop,
            high,
            table.alive,
            self.temperatures(table, world),
            0.0 if way.temperature is None else way.temperature,
            way.threshold,
            world.dt,
            developed,
        )
        rows = table.by_uid()
        ripe = rows[(developed[rows] >= way.incubation * (1 - 1e-9)) & (table.cause[rows] == 0)]
        if ripe.size:
            table.cause[ripe] = world.cause(HATCHED)
            hatch(table, ripe, world.tables[way.into], world)

    def temperatures(self, table: Table, world: SpatialWorld) -> np.ndarray:
        """Return the temperatures of eggs, or of their places: f32[high] [K]."""
        p, high = table[Position], table.high
        if table.species.config is not None and "temperature" in table.species.config.properties:
            own: np.ndarray = table[Physical].temperature
            return own
        around = world.surroundings("temperature", p.x[:high], p.y[:high], p.z[:high])
        return around.astype(np.float32, copy=False)


@njit
def develop(first, last, alive, temperature, usual, threshold, dt, developed):
    """Let the living develop for a tick; `usual` [K] is the temperature at which time counts as it is, 0: at
    any."""
    for row in range(first, last):
        if alive[row]:
            rate = 1.0
            if usual > 0:
                rate = max((np.float64(temperature[row]) - threshold) / (usual - threshold), 0.0)
            developed[row] += rate * dt
