"""Water moves bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Position
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_value
from ecs_eco.space.barriers import barriers, stop
from ecs_eco.space.bodies import opaque_ground
from ecs_eco.space.gate import one_each
from ecs_eco.space.geometry import Extent, Places
from ecs_eco.space.sight import rock_between
from ecs_eco.space.terrain import ROCK, Ground, ground_at
from ecs_eco.space.water import carry, drift

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

STILL = np.zeros((0, 3), np.float32)


class Drift(System):
    """Currents move all bodies in the water. They push no body into rock, and no solid body through an
    immovable solid capsule or box. Heavy bodies sink to the bottom; light bodies rise to the surface."""

    needs = (Position,)
    phase = "move"
    divisible = True
    submodel = Submodel(
        "Drift and sinking",
        where=("water.current", "water.current_function", "body.sinking"),
        rules={
            "water.current": "A body moves at the velocity of the water at its depth, interpolated linearly "
            "between the given depths.",
            "body.sinking": "`dz/dt = −sinking`.",
        },
        changes=("Position",),
    )

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Move one kind of body."""
        water, species = world.environment.water, table.species
        if water is None and not (species.body.sinking or species.traits):
            return
        sinking = own_value(table, "body.sinking", np.float32(species.body.sinking))
        sinks = isinstance(sinking, np.ndarray) or bool(sinking)
        own = None if water is None or world.config is None else world.config.water.current_function
        current = STILL if water is None else water.current
        if own is None and not len(current) and not sinks:
            return
        space, p, high = world.space, table[Position], table.high
        places, dt = Places(p.x, p.y, p.z), np.float32(world.dt)
        walls = barriers(world, table.name) if species.body.solid else None
        ground = opaque_ground(world)
        held = walls is not None or ground.kind.size > 1
        before, carried = np.stack([p.x, p.y, p.z], 1)[:high] if held else STILL, np.zeros((1, 2), np.float32)
        if own is not None:
            flow = world.config.function(own)(world, p.x[:high], p.y[:high], p.z[:high])
            u, v, w = (one_each(a, high, own).astype(np.float32, copy=False) for a in flow)
            carry(table.alive[:high], u, v, w, dt, space.extent, places)
            carried = np.stack([u, v], 1) * dt
        if len(current) or sinks:
            world.split(drift, high, table.alive, current, sinking, dt, space.extent, places)
        if held:
            way = np.stack([p.x, p.y, p.z], 1)[:high] - before
            if space.torus:  # a function of the world can carry bodies around it
                lengths = space.lengths[:2]
                way[:, :2] -= lengths * np.floor((way[:, :2] - carried) / lengths + np.float32(0.5))
            if walls is not None:
                rows = table.rows()
                way[rows] *= stop(world, table, walls, before, way[rows])[:, None]
            if ground.kind.size > 1:
                stay_off_rock(table.alive, before, way, ground, space.extent, places)
        table.version += 1


@njit
def stay_off_rock(
    alive: np.ndarray, before: np.ndarray, way: np.ndarray, ground: Ground, space: Extent, places: Places
) -> None:
    """Move living bodies back to positions f32[rows, 3] [m] if their displacements f32[rows, 3] [m] lead into
    rock."""
    x, y, _ = places
    for row in range(len(before)):
        ax, ay = before[row, 0], before[row, 1]
        if alive[row] and (ax != x[row] or ay != y[row]) and ground_at(ground, ax, ay) != ROCK:
            if rock_between(ax, ay, way[row, 0], way[row, 1], ground, space) <= 1:
                x[row], y[row] = ax, ay
