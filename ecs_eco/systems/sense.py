"""Organisms sense."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Nervous, Position, Sensor
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.nervous.organs import blind
from ecs_eco.nervous.sensors.sense import NOTHING_SENSED
from ecs_eco.space.seekers import Seekers

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


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

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Fill the observation matrix of one species."""
        nerves = table.species.nerves
        seekers = Seekers(world, table)
        out = nerves.readout(seekers.n)
        nerves.rows = seekers.rows
        nerves.sensed = NOTHING_SENSED
        undivided, column = [], 0
        with world.bands.own(seekers.index, out):
            for sense, width in nerves.senses:
                if sense.divisible or world.bands.size == 1:
                    sense.read(world, table, seekers, out, column)
                else:
                    undivided.append((sense, column))
                column += width
        for sense, column in undivided:
            sense.read(world, table, seekers, out, column)
        if table.species.traits:
            blind(table, seekers.rows, out)
        uid = seekers.index.uid
        if world.bands.divided:
            here = world.bands.entries(seekers.index)
            nerves.rows, uid = seekers.rows[here], uid[here]
            nerves.x = np.ascontiguousarray(out.T[:, here]).T
        if Sensor in table:
            nerves.sensed = uid.copy(), nerves.x
