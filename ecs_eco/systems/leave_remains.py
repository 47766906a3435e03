"""Dead organisms leave remains."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Body, Chemistry, Matter, Metabolism, Physical, Position, Shape
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.life.matter import bodies, remaining

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class LeaveRemains(System):
    """A dead organism leaves an object where it died, of the type that its species names. The object has the
    body's radius, mass, temperature and substances, and its remaining energy if the type holds energy.
    Eaten organisms leave nothing, because their bodies are consumed."""

    phase = "die"
    divisible = True
    submodel = Submodel("Remains", where=("remains",), reads=("remains",))

    def start(self, world: SpatialWorld) -> None:
        """Watch for deaths from any cause."""
        world.on_death.append(self.leave)

    def process(self, *_: object) -> None:
        """Do nothing: remains are created when a death takes effect."""

    def leave(self, table: Table, rows: np.ndarray) -> None:
        """Request one object for each dying organism that was not eaten; rows i64[k] are in uid order."""
        world, remains = self.world, table.species.remains
        if remains is not None:
            rows = rows[remaining(world, table, rows)]
            if rows.size:
                kept: list[tuple[Any, str]] = [(Position, f) for f in ("x", "y", "z", "heading")] + [
                    (Body, "radius"),
                    (Body, "mass"),
                ]
                kept += [(Shape, f) for f in Shape.fields]  # type: ignore[attr-defined]
                kept += [(Chemistry, "molarity"), (Matter, "residue")]
                kept += [(Physical, f) for f in Physical.fields]  # type: ignore[attr-defined]
                into = world.tables[remains]
                values = {(c, f): table.field(c, f)[rows] for c, f in kept if c in table and c in into}
                if Metabolism in table and Metabolism in into:
                    values[Metabolism, "energy"] = table[Metabolism].energy[rows].clip(0, None)
                if Chemistry in table and Matter in into:
                    values[Matter, "volume"] = bodies(table).volume[rows]
                into.request(table.uid[rows], values)
