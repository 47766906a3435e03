"""Debug mode, ECS_ECO_DEBUG=1: checks after each system, which name the faulty system and never change
results. They are too slow to be always on.

`invariants` checks what must hold at any time, `comparison` compares the world before and after a system, and
`watch` runs the checks. Data written into a world from outside is always checked, in `ecs_eco.space.gate`.
See docs/how-to/debugging.md.
"""

from ecs_eco.debug.columns import DebugError, StaleHandle
from ecs_eco.debug.watch import Debug, start

__all__ = ["Debug", "DebugError", "StaleHandle", "start"]
