"""What objects hold, how they come back, move and are built; what animals do with them."""

from __future__ import annotations

from ecs_eco.engine.section import NonNegative, Section, Share, quantity


class Store(Section):
    """Energy in objects, for those who eat them (`diet.efficiency`); remains hold what the dead body held.
    """

    initial: NonNegative = quantity("energy of each object but remains", "energy", 0.0)
    decay: NonNegative = quantity("share that rots away in a second; what rots vanishes at last", "1/s", 0.0)
    left: Share = quantity("share of a store that rots: the object vanishes when so much would be left of it",
                           "1", 0.01)
