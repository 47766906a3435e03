"""What `ecs-eco new` writes: worlds and packages of one's own to begin with.

Their texts are the files in the folders here, with `.template` at the end where a tool would take them for
code of this package. Shipped worlds, which have results, belong to `ecs_eco.worlds`.
"""

from ecs_eco.templates.from_raster import world_from_raster
from ecs_eco.templates.write import ORIGINS, new_package, new_world

__all__ = ["ORIGINS", "new_package", "new_world", "world_from_raster"]
