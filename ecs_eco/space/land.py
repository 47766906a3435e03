"""What real land makes of a terrain: relief, water, and classes of their own growth, pace and shelter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ecs_eco.engine.elementary import power
from ecs_eco.space.drainage import drained
from ecs_eco.space.geometry import cells_of

OPEN, WATER, ROCK = 0, 1, 2
GROUNDS = {"open": OPEN, "water": WATER, "rock": ROCK}
Value = Callable[[Any], float]


class LandMaps:
    """Factors of each cell, f32[ny, nx], or None where all are 1: growth, pace and cost of classes;
    `shelter`, shares, or None where all are 0. `wet` bool[ny, nx]: streams. `sha256` names the land."""

    def __init__(self, land: Any, classes: Sequence[Any]) -> None:
        self.kinds, self.sha256 = land.kinds, land.sha256
        self.colors: list[str | None] = [c.color for c in classes]
        self.growth = _map(land.kinds, classes, lambda c: c.growth, 1.0)
        self.pace = _map(land.kinds, classes, lambda c: c.pace, 1.0)
        self.cost = _map(land.kinds, classes, lambda c: c.cost, 1.0)
        self.shelter = _map(land.kinds, classes, lambda c: c.shelter, 0.0)
        self.wet: np.ndarray | None = None


def lay(terrain: Any, land: Any, section: Any) -> None:
    """Give a terrain the relief, water, classes, roads and fences of `land` (`ecs_eco.config.land`), by the
    section `terrain` of a world file."""
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
            terrain.pave(np.array(line["line"], float), line["width"], line["pace"], line["cost"])
        else:
            terrain.fence(np.array(line["line"], float))
    terrain.draw_roads()


def _collect(terrain: Any, drainage: Any, vertical: float, scale: float) -> None:
    """Make sea, lakes and streams; their surface is flat, the level of the water."""
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


def _map(kinds: np.ndarray, classes: Sequence[Any], value: Value, usual: float) -> np.ndarray | None:
    values = np.array([usual, *map(value, classes)], np.float32)
    return None if (values == np.float32(usual)).all() else values[kinds]


def at_places(factors: np.ndarray, terrain: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the numbers of a map f32[ny, nx] of a terrain at places f32[n] [m]: f32[n]."""
    out: np.ndarray = factors[cells_of(y, terrain.inverse[1], terrain.shape[0]),
                              cells_of(x, terrain.inverse[0], terrain.shape[1])]
    return out
