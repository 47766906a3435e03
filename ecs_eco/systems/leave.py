"""The dead become inanimate objects."""

from typing import Any

import numpy as np

from ecs_eco.components import Body, Chemistry, Physical, Position
from ecs_eco.system import System


class Leave(System):
    """What dies leaves an object of the type that its species names, where it died, with its mass and substances.

    The eaten leave nothing: their body is in another.
    """

    phase = "die"

    def process(self, *_: Any) -> None:
        """Ask for one object for each of those who die in this tick and were not eaten."""
        world = self.world
        for table in world.tables.values():
            remains = table.traits.get("remains")
            if remains is None:
                continue
            eaten = np.array([c.startswith("eaten") for c in world.causes], np.bool_)
            rows = np.flatnonzero(table.cause[: table.high])
            rows = rows[~eaten[table.cause[rows] - 1]]
            rows = rows[np.argsort(table.uid[rows])]
            if rows.size:
                kept: list[tuple[Any, str]] = [(Position, f) for f in ("x", "y", "z", "heading")] + [(Body, "radius"), (Body, "mass")]
                kept += [(Chemistry, "molarity")]
                kept += [(Physical, f) for f in Physical.fields]  # type: ignore[attr-defined]
                into = world.tables[remains]
                values = {(c, f): table.field(c, f)[rows] for c, f in kept if c in table and c in into}
                into.request(table.uid[rows], values)
