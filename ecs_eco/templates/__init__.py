"""Starter worlds and packages, which `ecs-eco new` writes.

Their texts are the files in these folders. Names of code files end in `.template`, so that tools do not treat
them as code of this package. Shipped worlds, which have results, belong to `ecs_eco.worlds`.
"""

from ecs_eco.templates.from_raster import world_from_raster
from ecs_eco.templates.write import ORIGINS, new_package, new_world

__all__ = ["ORIGINS", "new_package", "new_world", "world_from_raster"]
