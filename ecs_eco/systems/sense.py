"""Organisms sense."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Nervous, Position, Sensor
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.nervous.organs import blind
from ecs_eco.nervous.sensors.sense import NOTHING_SENSED, shared_out
from ecs_eco.space.seekers import Seekers

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.nervous.sensors.sense import Reading
    from ecs_eco.space.world import SpatialWorld

NOBODY: tuple[Any, ...] = ((), [], [])


class Sense(System):
    """Every sensor reads its property at its position on the body; all readings together form the vector x."""

    needs = (Position, Nervous)
    phase = "sense"
    divisible = True
    submodel = Submodel(
        "Sensing",
        where=("sensors",),
        reads=("sensors",),
        rules={
            "": "The readings of all sensors form the vector x (Strannegård et al. 2021). There is no "
            "measurement error."
        },
    )

    @cached_property
    def _shares(
        self,
    ) -> dict[str, tuple[tuple[Any, ...], list[tuple[Reading, int]], list[tuple[Reading, int]]]]:
        """For each table: its senses and the number of processes, and the result of `shared_out` for them."""
        return {}

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Fill the observation matrix of one species."""
        nerves = table.species.nerves
        seekers = Seekers(world, table)
        out = nerves.readout(seekers.n)
        nerves.rows = seekers.rows
        nerves.sensed = NOTHING_SENSED
        asked = (*nerves.senses, world.bands.size)
        if self._shares.get(table.name, NOBODY)[0] != asked:
            self._shares[table.name] = asked, *shared_out(nerves.senses, world.bands.size == 1)
        _, shared, undivided = self._shares[table.name]
        if world.bands.size == 1 and not world.bands.divided:
            undivided = shared
        else:
            with world.bands.own(seekers.index, out):
                for read, first in shared:
                    read(world, table, seekers, out, first)
        for read, first in undivided:
            read(world, table, seekers, out, first)
        if table.species.traits:
            blind(table, seekers.rows, out)
        uid = seekers.index.uid
        if world.bands.divided:
            here = world.bands.entries(seekers.index)
            nerves.rows, uid = seekers.rows[here], uid[here]
            nerves.x = np.ascontiguousarray(out.T[:, here]).T
        if Sensor in table:
            nerves.sensed = uid.copy(), nerves.x
