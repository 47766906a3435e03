"""Organisms sense."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ecs_eco.components import Nervous, Position, Sensor
from ecs_eco.engine.system import System
from ecs_eco.nervous.organs import blind
from ecs_eco.nervous.sensors.sense import Seekers

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

SHIPPED = "ecs_eco.nervous.sensors."


class Sense(System):
    """Every sensor reads its property at its place on the body; together they are the vector x."""

    needs = (Position, Nervous)
    phase = "sense"

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Fill the observation matrix of one species."""
        nerves = table.species.nerves
        seekers = Seekers(world, table)
        out, column = nerves.readout(seekers.n), 0
        nerves.rows = seekers.rows
        seen: Any = table.derived.get(Sensor)  # Readings, which only keeps what it is handed
        if seen is not None:
            seen.take(seekers.index.uid[:0], out[:0])
        # whole senses for each thread, wide ones first
        shares: list[list[tuple[Any, int]]] = [[] for _ in range(world.threads)]
        undivided: list[tuple[Any, int]] = shares[0] if world.bands.size == 1 else []
        columns: list[tuple[Any, int, int]] = []
        for sense, width in nerves.senses:
            columns.append((sense, width, column))
            column += width
        for place, (sense, _, first) in enumerate(sorted(columns, key=lambda c: -c[1])):
            # functions of the user's own run on the world's thread
            own = (not sense.__module__.startswith(SHIPPED) or sense.__qualname__.startswith("ambient")
                   or getattr(sense, "by_light", False))
            (undivided if own else shares[place % world.threads]).append((sense, first))

        def read(share: list[tuple[Any, int]]) -> None:
            for sense, first in share:
                sense(world, table, seekers, out, first)

        with world.bands.over(seekers.index, out):
            world.together(*(lambda share=share: read(share) for share in shares if share))
        if undivided is not shares[0]:
            read(undivided)
        if table.species.traits:
            blind(table, seekers.rows, out)
        if seen is not None:
            seen.take(seekers.index.uid.copy(), out)
