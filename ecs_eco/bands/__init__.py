"""One world over many processes: each does the work of a band of the map, or holds it alone.

What of a system may be divided, the system says, by `world.bands` (`ecs_eco.space.one_band`); many worlds
belong to `ecs_eco.lab`. mpi4py is imported when a world is divided. See docs/explanation/bands.md.
"""

from ecs_eco._lazy import lazy

__all__ = ["Bands", "Divided", "divide"]
__getattr__ = lazy(
    __name__,
    {"Bands": "ecs_eco.bands.bands", "Divided": "ecs_eco.bands.divided", "divide": "ecs_eco.bands.begin"},
)
