"""Split one world across several processes. Each computes one band of the map and can store only that band.

A system declares its divisible work through `world.bands` (`ecs_eco.space.one_band`). To run many worlds, use
`ecs_eco.lab`. mpi4py is imported only when needed. See docs/explanation/bands.md.
"""

from ecs_eco._lazy import lazy

__getattr__ = lazy(__name__, {".bands": "Bands", ".divided": "Divided", ".begin": "divide"})
