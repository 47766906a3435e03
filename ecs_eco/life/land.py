"""Real land in a world: relief, water, land-cover classes, roads and fences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import power
from ecs_eco.space.drainage import drained
from ecs_eco.space.land import LandMaps
from ecs_eco.space.terrain import OPEN, ROCK, WATER, Road

if TYPE_CHECKING:
    from ecs_eco.config.land.land import Land
    from ecs_eco.config.models.land import Drainage
    from ecs_eco.config.models.surroundings import Terrain as Section
    from ecs_eco.space.terrain import Terrain

GROUNDS = {"open": OPEN, "water": WATER, "rock": ROCK}


def lay(terrain: Terrain, land: Land, section: Section) -> None:
    """Give a terrain the relief, water, classes, roads and fences of `land`, as configured in a section of a
    world file."""
    classes = list(section.classes.values())
    terrain.height += land.elevation
    terrain.land = LandMaps(land, classes)
    for i, kind in enumerate(classes):
        terrain.ground[land.kinds == i + 1] = GROUNDS[kind.ground]
    terrain.ground[land.lakes] = WATER
    if section.drainage is not None:
        _collect(terrain, section.drainage, section.vertical or 1.0, section.scale or 1.0)
    for line in land.lines:
        if line["make"] == "roads":
            how = line["width"], line["pace"], line["cost"]
            terrain.roads.append(Road(np.array(line["line"], float), *how))
        else:
            terrain.fences.append(np.array(line["line"], float))
    terrain.draw_roads()
    terrain.draw_fences()


def _collect(terrain: Terrain, drainage: Drainage, vertical: float, scale: float) -> None:
    """Create sea, lakes and streams; the surface of each is flat, at water level."""
    from scipy import ndimage

    height, ground = terrain.height, terrain.ground
    sea = np.zeros(height.shape, np.bool_)
    if drainage.sea is not None:
        surface = np.float32(drainage.sea * vertical)
        sea = height <= surface
        height[sea], ground[sea] = surface, WATER
    if drainage.depth is None and drainage.stream is None:
        return
    level, area = drained(height, sea)
    deep = level - height
    if drainage.depth is not None:
        lakes, n = ndimage.label(deep > 1e-6, np.ones((3, 3)))
        deepest = ndimage.maximum(deep, lakes, np.arange(1, n + 1)) if n else np.zeros(0)
        filled = np.append(False, np.asarray(deepest) >= drainage.depth * vertical)[lakes]
        height[filled], ground[filled] = level[filled].astype(np.float32), WATER
    if drainage.stream is not None and terrain.land is not None:
        side2 = 1.0 / float(terrain.inverse[0]) / float(terrain.inverse[1]) / power(scale, 2)
        terrain.land.wet = (area * side2 >= drainage.stream) & (ground == OPEN)
