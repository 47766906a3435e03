"""Objects are renewed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import scalars
from ecs_eco.components import Position
from ecs_eco.engine import random
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.life.founders import future, newcomers

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Renew(System):
    """Each object missing from the type's initial number reappears at a random position with a given
    probability per second, like falling fruit or stones carried by a stream."""

    needs = (Position,)
    phase = "reproduce"
    submodel = Submodel(
        "Renewal of objects",
        reads=("renewal",),
        rules={"": "A missing object comes back in a tick with probability `1 − exp(−renewal dt)`."},
        draws="which objects come back, and where",
    )
    asked_for = staticmethod(lambda table: table.species.renewal > 0)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Renew one type of object."""
        count, rate = table.species.count, table.species.renewal
        missing = count - table.n - table.waiting
        if rate == 0 or missing <= 0:
            return
        chance = -scalars.expm1(-rate * world.dt)
        salt = random.BIRTH + (3 << 8) + ((table.place + 1) << 20)
        come = int((random.draw_many(world.key, np.arange(missing, dtype=np.uint64), salt) < chance).sum())
        if come:
            table.request(
                np.zeros(come, np.uint64), newcomers(table, world, None, future(world, table, come))
            )
