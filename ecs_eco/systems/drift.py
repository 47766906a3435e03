"""Water carries what is in it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Position
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_value
from ecs_eco.space.gate import one_each
from ecs_eco.space.water import carry, drift

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

STILL = np.zeros((0, 3), np.float32)


class Drift(System):
    """Currents carry all bodies in the water; heavy ones sink to the bottom, light ones rise to the surface.
    """

    needs = (Position,)
    phase = "move"

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Carry one kind of bodies."""
        water, species = world.environment.water, table.species
        if water is None and not (species.sinking or species.traits):
            return
        space, p = world.space, table[Position]
        sinking = own_value(table, "body.sinking", np.float32(species.sinking))
        sinks = isinstance(sinking, np.ndarray) or bool(sinking)
        own = None if water is None or world.config is None else world.config.water.current_function
        current = STILL if water is None else water.current
        if own is not None:
            high = table.high
            flow = world.config.function(own)(world, p.x[:high], p.y[:high], p.z[:high])
            u, v, w = (one_each(a, high, own).astype(np.float32, copy=False) for a in flow)
            carry(table.alive[:high], u, v, w, np.float32(world.dt), space.lengths, space.torus,
                  p.x, p.y, p.z)
        if len(current) or sinks:
            height = np.float32(space.lengths[2])
            world.split(drift, table.high, table.alive, current, height, sinking,
                        np.float32(world.dt), space.lengths, space.torus, space.volume, p.x, p.y, p.z)
        if own is not None or len(current) or sinks:
            table.version += 1
