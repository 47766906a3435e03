"""One world over many processes: each does the work of a band of the map, and all stay the same to the bit.

Which work of a system may be divided, the system says, by `world.bands` (`ecs_eco.engine.bands`); many worlds
belong to `ecs_eco.experiments`. mpi4py is imported when a world is divided. See docs/explanation/bands.md.
"""

from ecs_eco._lazy import lazy

__all__ = ["Bands", "divide"]
__getattr__ = lazy(__name__, {"Bands": "ecs_eco.bands.bands", "divide": "ecs_eco.bands.bands"})
