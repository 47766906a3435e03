"""Positions and surroundings: edges, neighbors, sight, fields, terrain, sun and water.

Kernels in this package take views (named tuples of arrays), arrays and numbers. Code that uses them for
organisms belongs in `ecs_eco.nervous` and `ecs_eco.systems`.
"""

from ecs_eco.space.field import Field
from ecs_eco.space.geometry import Space
from ecs_eco.space.index import Index
from ecs_eco.space.seekers import Seekers
from ecs_eco.space.terrain import Terrain

__all__ = ["Field", "Index", "Seekers", "Space", "Terrain"]
