"""Debug mode, ECS_ECO_DEBUG=1: checks after each system, too slow to be always on;
they name it and change no result.

`invariants` holds at any time, `comparison` between before and after a system, `handles` for what users keep;
`watch` says when. What outsiders may write into a world is looked at always, in `ecs_eco.space.gate`. See
docs/how-to/debugging.md.
"""

from ecs_eco.debug.errors import DebugError, StaleHandle
from ecs_eco.debug.watch import Debug, start

__all__ = ["Debug", "DebugError", "StaleHandle", "start"]
