"""Debug mode (ECS_ECO_DEBUG=1): check the world after each system and name the faulty system. Results do not
change. The checks are too slow to be on by default.

`invariants` checks conditions that must always be true, `comparison` compares the world before and after a
system, and `watch` runs the checks. Data written into a world from outside is always checked, by
`ecs_eco.space.gate`. See docs/how-to/debugging.md.
"""

from ecs_eco.debug.columns import DebugError, StaleHandle
from ecs_eco.debug.watch import Debug, start

__all__ = ["Debug", "DebugError", "StaleHandle", "start"]
