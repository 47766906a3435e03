"""A picture of a world for render(): discs in the colours of their species."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.components import Body, Position

WIDTH = 480  # px of the longer side
PAPER = (247, 246, 242)


def draw(world: Any) -> np.ndarray:
    """Return the world from above, in a volume from the side: u8[height, width, 3]."""
    across, up = ("x", "z") if world.space.volume else ("x", "y")
    extent = world.space.size[0], world.space.size[2 if world.space.volume else 1]
    scale = WIDTH / max(extent)
    shape = max(1, round(extent[1] * scale)), max(1, round(extent[0] * scale))
    picture = np.full((*shape, 3), PAPER, np.uint8)
    for table in world.tables.values():
        if Position in table and table.n:
            rows = table.rows()
            place = table[Position]
            _discs(
                picture,
                getattr(place, across)[rows] * scale,
                shape[0] - 1 - getattr(place, up)[rows] * scale,
                table[Body].radius[rows] * scale,
                _rgb(table.species.color),
            )
    return picture


def _discs(
    picture: np.ndarray, x: np.ndarray, y: np.ndarray, radius: np.ndarray, colour: tuple[int, ...]
) -> None:
    """Draw discs at places f32[n] [px], each at least a pixel large."""
    for size in np.unique(np.clip(np.round(radius), 0, 40)).astype(int):
        here = np.clip(np.round(radius), 0, 40) == size
        dy, dx = np.mgrid[-size : size + 1, -size : size + 1]
        inside = dx * dx + dy * dy <= (size + 0.25) ** 2
        columns = (x[here, None] + dx[inside]).astype(int).clip(0, picture.shape[1] - 1)
        rows = (y[here, None] + dy[inside]).astype(int).clip(0, picture.shape[0] - 1)
        picture[rows, columns] = colour


def _rgb(colour: str | None) -> tuple[int, ...]:
    text = (colour or "#808080").lstrip("#")
    return tuple(int(text[i : i + 2], 16) for i in (0, 2, 4))
