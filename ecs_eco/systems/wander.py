"""Animals wander unless they decide to turn."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.components import Nervous, Position
from ecs_eco.engine import random
from ecs_eco.engine.random import draw_many
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_value
from ecs_eco.life.torpor import awake

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

WHOLE = np.float32(2 * math.pi)


class Wander(System):
    """An animal that does not decide to turn changes its heading by a normally distributed angle of variance
    turn² dt. This is a correlated random walk whose statistics do not depend on the length of a tick."""

    needs = (Position, Nervous)
    phase = "move"
    divisible = True
    submodel = Submodel(
        "Wandering",
        reads=("wander",),
        rules={"": "`heading(t + dt) = heading(t) + turn √dt N(0, 1)` (Kareiva & Shigesada 1983)."},
        changes=("Position.heading",),
        draws="the change of heading",
    )
    asked_for = staticmethod(lambda table: table.species.wander is not None)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Turn the members of one species that do not decide to turn."""
        if (way := table.species.wander) is None:
            return
        nerves, walks = table.species.nerves, awake(table)[: table.high].copy()
        for side in ("left", "right"):
            if side in nerves.groups.get("turn", ()):
                walks &= ~nerves.doing(table, f"turn.{side}")[: table.high]
        rows = np.flatnonzero(walks)
        turn = np.broadcast_to(own_value(table, "wander.turn", np.float32(way.turn)), table.high)[rows]
        heading = table[Position].heading
        turned = heading[rows] + turn * np.float32(math.sqrt(world.dt)) * normal(world.key, table.uid[rows])
        heading[rows] = turned - WHOLE * np.floor(turned / WHOLE)


def normal(key: np.uint64, uid: np.ndarray) -> np.ndarray:
    """Draw a standard normal number for each uid u64[n]: f32[n] (Box & Muller 1958)."""
    u, v = (draw_many(key, uid, random.WANDER + (i << 8)) for i in range(2))
    radius = np.sqrt(np.float32(-2) * arrays.log(np.float32(1) - u))  # u is below 1
    return np.asarray(radius * arrays.cos(WHOLE * v), np.float32)
