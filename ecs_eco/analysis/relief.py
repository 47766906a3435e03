"""The colors of the ground: hills shaded by the sun, water, rock, and land-cover classes."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from ecs_eco.analysis.palette import rgb
from ecs_eco.analysis.style import Axes
from ecs_eco.config.land.raster import DAMAGED, read_npz

LAND, WATER, ROCK = (0.955, 0.955, 0.925), (0.66, 0.80, 0.90), (0.60, 0.59, 0.57)
OF_CLASS = ("color", None), ("ground", "open")  # keys of a land-cover class, and their defaults
GROUNDS = ["open", "water", "rock"]  # ground of a class, by number
SUN = 315.0, 45.0  # azimuth and height of the light on maps [degrees]: upper left, halfway up
STEEP = 0.5  # slope to which the 98th percentile of slopes is scaled


class Relief(NamedTuple):
    """The ground of a world as arrays [ny, nx] with the southernmost row first."""

    height: np.ndarray  # f32 [m]
    ground: np.ndarray  # u8: 1 water, 2 rock
    side: float  # of a cell [m]
    torus: bool = False
    kinds: np.ndarray | None = None  # u8: class of land cover
    colors: Sequence[str | None] = ()  # of classes
    wet: np.ndarray | None = None  # bool: streams
    grounds: Sequence[str] = ()  # of classes

    @classmethod
    def of(cls, terrain: Any) -> Self:
        """Return the ground of a live world."""
        land = terrain.land
        more = () if land is None else (land.kinds, land.colors, land.wet, land.grounds)
        return cls(terrain.height, terrain.ground, 1 / float(terrain.inverse[0]), terrain.space.torus, *more)

    @classmethod
    def kept(cls, run: Path, config: Mapping[str, Any]) -> Self | None:
        """Return the ground stored in a run folder, or None if it is flat and open, or was not stored."""
        terrain, space = config.get("terrain"), config["space"]
        try:
            held = read_npz(run / "terrain.npz")
            height, ground = held["height"], held["ground"]
        except DAMAGED:
            return None
        classes = ((terrain or {}).get("classes") or {}).values()
        colors, grounds = ([kind.get(key, word) for kind in classes] for key, word in OF_CLASS)
        side, torus = space["size"][0] / height.shape[1], space["edges"] == "torus"
        return cls(height, ground, side, torus, held.get("kinds"), colors, held.get("wet"), grounds)

    def shade(self) -> np.ndarray:
        """Return the brightness of the sunlit ground minus that of flat ground, f64[ny, nx] (Horn 1981)."""
        from matplotlib.colors import LightSource

        high = np.pad(self.height.astype(float), 1, mode="wrap" if self.torus else "edge")[::-1]
        slope = np.hypot(*np.gradient(high, self.side))
        steep = float(np.percentile(slope, 98))
        times = STEEP / steep if steep > 0 else 1.0
        # unlike matplotlib's hillshade, this does not stretch the contrast to 0 … 1
        normal = LightSource(*SUN)
        dy, dx = np.gradient(times * high, -self.side, self.side)
        length = np.sqrt(1 + dx * dx + dy * dy)
        lit = (np.stack([-dx, -dy, np.ones_like(dx)], -1) * normal.direction).sum(-1) / length
        out: np.ndarray = (lit - normal.direction[2])[1:-1, 1:-1][::-1]
        return out

    def colours(self) -> np.ndarray:
        """Return each cell's color, f64[ny, nx, 3], from 0 to 1; water and rock in a class may have its color."""
        high = (self.height - self.height.min()) / max(float(np.ptp(self.height)), 1e-9)
        colour = np.array(LAND) - 0.16 * high[..., None] * np.array([0.55, 0.75, 1.3])
        own = np.zeros(self.ground.shape, np.bool_)
        for i, (code, ground) in enumerate(zip(self.colors, self.grounds, strict=True)):
            if code is not None and self.kinds is not None:
                there = self.kinds == i + 1
                colour[there] = 0.35 * np.array(LAND) + 0.65 * np.array(rgb(code)) / 255
                own |= there & (self.ground == GROUNDS.index(ground))
        colour[(self.ground == 2) & ~own] = ROCK
        colour = colour * (1 + 0.75 * self.shade()[..., None])
        if self.wet is not None:
            colour[self.wet] = WATER
        colour[(self.ground == 1) & ~own] = WATER
        return np.clip(colour, 0, 1)


def draw_relief(ax: Axes, relief: Relief, size: Sequence[float]) -> Any:
    """Draw the ground below everything else, on axes in meters; return the artist."""
    where: Any = {"extent": (0, size[0], 0, size[1]), "origin": "lower", "aspect": ax.get_aspect()}
    return ax.imshow(relief.colours(), zorder=0.4, interpolation="nearest", **where)
