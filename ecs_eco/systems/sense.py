"""Organisms sense."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

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

SHIPPED = "ecs_eco.nervous.sensors."
Share = list[tuple[Any, int]]  # senses, and the first column of each
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
    def _shares(self) -> dict[str, tuple[tuple[Any, ...], Share, Share]]:
        """For each table: its senses and the number of processes, the senses that each process reads for its
        own part, and those that every process reads for all organisms."""
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
                for sense, first in shared:
                    sense(world, table, seekers, out, first)
        for sense, first in undivided:
            sense(world, table, seekers, out, first)
        if table.species.traits:
            blind(table, seekers.rows, out)
        uid = seekers.index.uid
        if world.bands.divided:
            here = world.bands.entries(seekers.index)
            nerves.rows, uid = seekers.rows[here], uid[here]
            nerves.x = np.ascontiguousarray(out.T[:, here]).T
        if Sensor in table:
            nerves.sensed = uid.copy(), nerves.x


def shared_out(senses: Sequence[tuple[Any, int]], alone: bool) -> tuple[Share, Share]:
    """Return the senses that each process reads for its own part, wide ones first, and, if there are several
    processes, those that every process reads for all organisms."""
    shared: Share = []
    undivided: Share = []
    for sense, _, first in sorted(joined(senses), key=lambda one: -one[1]):
        # user-defined functions, and readings that are the same for all
        own = (
            not sense.__module__.startswith(SHIPPED)
            or sense.__qualname__.startswith("ambient")
            or getattr(sense, "by_light", False)
        )
        (undivided if own and not alone else shared).append((sense, first))
    return shared, undivided


def joined(senses: Sequence[tuple[Any, int]]) -> list[tuple[Any, int, int]]:
    """Return senses with their widths and first columns; senses that are read together are merged into one at
    the position of the first."""
    groups: dict[Any, list[tuple[Any, int, int]]] = {}
    column = 0
    for number, (sense, width) in enumerate(senses):
        shipped = sense.__module__.startswith(SHIPPED)
        groups.setdefault(getattr(sense, "joint", number) if shipped else number, []).append(
            (sense, width, column)
        )
        column += width
    parts = []
    for joint, group in groups.items():
        if isinstance(joint, tuple):
            together = joint[0]([(sense, first) for sense, _, first in group])
            parts.append((together, sum(width for _, width, _ in group), group[0][2]))
        else:
            parts += group
    return parts
