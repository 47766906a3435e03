"""People harvest and plant."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.elementary import scalars
from ecs_eco.components import Body, Position
from ecs_eco.engine import random
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.life.births import room
from ecs_eco.life.founders import future, newcomers
from ecs_eco.space.gate import newborn
from ecs_eco.space.region import Region

if TYPE_CHECKING:
    from ecs_eco.config.models.interventions import Harvest, Plant, Use
    from ecs_eco.space.world import SpatialWorld

PLANTING = random.CULL + (1 << 24)  # purpose of the draws for the number of newcomers


class UseLand(System):
    """People harvest and plant (fishing, felling, sowing, reaping), in the order listed in the section
    `land_use`.

    Each individual of the right size in the region is taken with probability 1 − exp(−rate dt); if a quota
    would be exceeded, the individuals with the lowest draws are taken. They die at the end of the `die` phase
    of this tick; newcomers are alive from the end of the `reproduce` phase on.
    """

    phase = "environment"
    submodel = Submodel(
        "Harvest and planting",
        reads=("land_use",),
        rules={
            "land_use.kind=harvest": "An individual in the region is taken in a tick with probability "
            "`1 − exp(−rate dt)`.",
            "land_use.quota": "If the quota would be exceeded, the individuals with the lowest draws are taken.",
            "land_use.kind=plant": "In a tick, `rate dt` newcomers arrive; any fractional part is the "
            "probability of one more. They get only slots of `max_count` that are free at the start of the tick.",
        },
        draws="which individuals are harvested, and where newcomers are planted",
    )
    asked_for = staticmethod(lambda table: table.species.used)
    world: Any

    def __init__(self) -> None:
        self.taken = np.zeros((0, 2), np.int64)  # for each land use: the year, and the number taken that year

    def start(self, world: SpatialWorld) -> None:
        """Register the causes of death."""
        if world.config is not None:
            self.taken = np.zeros((len(world.config.land_use), 2), np.int64)
            for use in world.config.land_use:
                if use.kind == "harvest":
                    world.cause(use.cause)

    def process(self, *_: object) -> None:
        """Harvest and plant in this tick."""
        world = self.world
        for i, use in enumerate(() if world.config is None else world.config.land_use):
            if use.active(world.tick, world.dt):
                getattr(self, use.kind)(world, use, i)

    def harvest(self, world: SpatialWorld, use: Harvest, i: int) -> None:
        """Mark individuals to be harvested."""
        table, year = world.table(use.species), use.year(world.tick, world.dt)
        if self.taken[i, 0] != year:
            self.taken[i] = year, 0
        rows = self.there(world, use)
        rows = rows[table.cause[rows] == 0]
        radius = table[Body].radius[rows]
        rows = rows[(radius >= (use.least or 0.0)) & (radius <= (math.inf if use.most is None else use.most))]
        drawn = random.draw_many(world.key, table.uid[rows], random.CULL + ((i + 1) << 8))
        order = np.argsort(drawn, kind="stable")
        rows = rows[order[drawn[order] < -scalars.expm1(-use.rate * world.dt)]]
        if use.quota is not None:
            rows = rows[: max(0, use.quota - int(self.taken[i, 1]))]
        table.cause[rows] = world.cause(use.cause)
        self.taken[i, 1] += rows.size

    def plant(self, world: SpatialWorld, use: Plant, i: int) -> None:
        """Request rate × dt newcomers; any fractional part is the probability of one more."""
        table = world.table(use.species)
        count = int(use.rate * world.dt + float(random.draw(world.key, np.uint64(i), PLANTING)))
        if use.up_to is not None:
            count = min(count, max(0, use.up_to - self.there(world, use).size))
        count = room(table, world, count)
        if count == 0:
            return
        within = None if use.region is None else Region(world.space, use.region)
        values = newcomers(table, world, table.species.section, future(world, table, count), within)
        values = newborn(world, table, values, f"land_use: plant {use.species!r}")
        table.request(np.zeros(values[Position, "x"].size, np.uint64), values)

    def there(self, world: SpatialWorld, use: Use) -> np.ndarray:
        """Return the living rows in the region of a land use, in uid order: i64[k]."""
        table = world.table(use.species)
        rows, p = table.by_uid(), table[Position]
        return rows if use.region is None else rows[Region(world.space, use.region).has(p.x[rows], p.y[rows])]

    def state(self) -> dict[str, np.ndarray]:
        """Return the number taken and the year of that count for each land use."""
        return {"taken": self.taken.copy()}

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Load a `state()`."""
        self.taken[...] = state["taken"]
