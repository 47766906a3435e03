"""Where things are: extent and edges, the neighbour index, scalar fields, terrain.

Nothing here knows what lives in the space: kernels take arrays and numbers.
"""

from ecs_eco.space.field import Field
from ecs_eco.space.geometry import Space
from ecs_eco.space.index import Index
from ecs_eco.space.terrain import Terrain

__all__ = ["Field", "Index", "Space", "Terrain"]
