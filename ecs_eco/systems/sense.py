"""Organisms sense."""

from typing import Any

from ecs_eco.components import Nervous, Position
from ecs_eco.nervous.senses import Seekers
from ecs_eco.system import System


class Sense(System):
    """Every sensor reads its property at its place on the body; together they are the vector x."""

    needs = (Position, Nervous)
    phase = "sense"

    def update(self, table: Any, world: Any) -> None:
        """Fill the observation matrix of one species."""
        nerves = table.traits["nerves"]
        seekers = Seekers(world, table)
        out, column = nerves.readout(seekers.n), 0
        nerves.rows = seekers.rows
        for sense, width in nerves.senses:
            sense(world, table, seekers, out, column)
            column += width
