"""Organisms sense."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Nervous, Position, Sensor
from ecs_eco.engine.system import System
from ecs_eco.nervous.organs import blind
from ecs_eco.nervous.sensors.sense import NOTHING_SENSED, Seekers

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

SHIPPED = "ecs_eco.nervous.sensors."
Share = list[tuple[Any, int]]  # senses, and the first column of each
NOBODY: tuple[Any, ...] = ((), [], [])


class Sense(System):
    """Every sensor reads its property at its place on the body; together they are the vector x."""

    needs = (Position, Nervous)
    phase = "sense"

    @cached_property
    def _shares(self) -> dict[tuple[str, bool], tuple[tuple[Any, ...], list[Share], Share]]:
        """By table, on several threads and on one: what its members sense, in how many processes; and who
        reads what."""
        return {}

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Fill the observation matrix of one species."""
        nerves = table.species.nerves
        seekers = Seekers(world, table)
        out = nerves.readout(seekers.n)
        nerves.rows = seekers.rows
        nerves.sensed = NOTHING_SENSED
        asked, parallel = (*nerves.senses, world.bands.size), world.workers.parallel
        if self._shares.get((table.name, parallel), NOBODY)[0] != asked:
            self._shares[table.name, parallel] = asked, *shared_out(nerves.senses, parallel,
                                                                    world.bands.size == 1)
        _, shares, undivided = self._shares[table.name, parallel]
        if len(shares) == 1 and world.bands.size == 1 and not world.bands.divided:
            undivided = shares[0]
        else:
            with world.bands.own(seekers.index, out):
                world.together(*[partial(read, share, world, table, seekers, out) for share in shares])
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


def read(share: Share, world: SpatialWorld, table: Table, seekers: Seekers, out: np.ndarray) -> None:
    """Let some senses of a species read."""
    for sense, first in share:
        sense(world, table, seekers, out, first)


def shared_out(senses: Sequence[tuple[Any, int]], parallel: bool, alone: bool) -> tuple[list[Share], Share]:
    """Return pieces of work, the first of which is for the world's own thread: one of all senses, or of each
    where there are several threads, wide ones first; and what is read after them, by every process where this
    one is not alone."""
    shares: list[Share] = [[] for _ in range(len(senses) + 1 if parallel else 1)]
    undivided: Share = shares[0] if alone else []
    for place, (sense, _, first) in enumerate(sorted(joined(senses), key=lambda one: -one[1])):
        # functions of the user's own run on the world's thread
        own = (not sense.__module__.startswith(SHIPPED) or sense.__qualname__.startswith("ambient")
               or getattr(sense, "by_light", False))
        (undivided if own else shares[place + 1 if parallel else 0]).append((sense, first))
    return [share for share in shares if share], [] if alone else undivided


def joined(senses: Sequence[tuple[Any, int]]) -> list[tuple[Any, int, int]]:
    """Return senses with their widths and first columns, where one stands for all that are read together, in
    the place of the first of them."""
    groups: dict[Any, list[tuple[Any, int, int]]] = {}
    column = 0
    for number, (sense, width) in enumerate(senses):
        shipped = sense.__module__.startswith(SHIPPED)
        groups.setdefault(getattr(sense, "joint", number) if shipped else number,
                          []).append((sense, width, column))
        column += width
    parts = []
    for joint, group in groups.items():
        if isinstance(joint, tuple):
            together = joint[0]([(sense, first) for sense, _, first in group])
            parts.append((together, sum(width for _, width, _ in group), group[0][2]))
        else:
            parts += group
    return parts
