"""Where things are and what surrounds them: edges, neighbours, sight, fields, terrain, sun and water.

What the living do with it belongs to `ecs_eco.nervous` and `ecs_eco.systems`: kernels here take arrays and
numbers.
"""

from ecs_eco.space.field import Field
from ecs_eco.space.geometry import Space
from ecs_eco.space.index import Index
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.terrain import Terrain

__all__ = ["Field", "Index", "Seekers", "Space", "Terrain"]
