"""Islands that exchange migrants: the run of a whole archipelago, from barrier to barrier.

What happens to migrants within a world belongs to `ecs_eco.life.migration`, what a run of one world
leaves to `ecs_eco.runs`.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy, listing

if TYPE_CHECKING:
    from ecs_eco.archipelago.run import Archipelago

__all__ = ["Archipelago"]
__getattr__ = lazy(__name__, {"Archipelago": "ecs_eco.archipelago.run"})
__dir__ = listing(globals(), __all__)
