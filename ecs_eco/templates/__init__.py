"""Starter worlds and packages, written by `ecs-eco new`.

Their files are in these folders. Names of code files end in `.template`, so that tools do not treat them as
this package's code. Shipped worlds are in `ecs_eco.worlds`.
"""

from ecs_eco.templates.from_raster import world_from_raster
from ecs_eco.templates.write import ORIGINS, new_package, new_world

__all__ = ["ORIGINS", "new_package", "new_world", "world_from_raster"]
