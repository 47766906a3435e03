"""Maps of fields that a page lays over its scene: smells, substances, light, growth of the land."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World

CELLS = 160  # of a map along each side
LAYERS = 64  # of depth, for what is no lattice
GROWTH = "growth of the land"


def names_of(world: World) -> list[str]:
    """Return the names of what can be laid over the scene: fields, light where it varies in the water, and
    the growth that real land allows."""
    land = getattr(world.terrain, "land", None)
    more = ["light"] if world.space.volume and "light" in world.environment else []
    return [*more, *world.fields, *([GROWTH] if getattr(land, "growth", None) is not None else [])]


def map_of(world: World, name: str) -> dict[str, Any]:
    """Return the message "field": values u8[ny, nx], from low to high, in base64; on land as seen from above,
    from the south-west; in water as seen from the side, the mean from front to back, from the bottom.

    KeyError for a name that is not among `names_of`.
    """
    values, unit = _values(world, name)
    ny, nx = values.shape
    values = values[:: max(1, -(-ny // CELLS)), :: max(1, -(-nx // CELLS))]
    low, high = min(0.0, float(values.min())), float(values.max())
    graded = np.zeros(values.shape, np.uint8)
    if high > low:
        graded = np.rint(255 * (values - low) / (high - low)).astype(np.uint8)
    return {
        "kind": "field",
        "name": name,
        "tick": world.tick,
        "unit": unit,
        "nx": values.shape[1],
        "ny": values.shape[0],
        "low": float(f"{low:.4g}"),
        "high": float(f"{high:.4g}"),
        "values": base64.b64encode(graded.tobytes()).decode(),
    }


def _values(world: World, name: str) -> tuple[np.ndarray, str]:
    """Return the values f64[ny, nx] of a map, and their unit."""
    terrain: Any = world.terrain
    if name in names_of(world):
        if name == "light" and name not in world.fields:
            x, y, top = (float(side) for side in world.space.size)
            z = ((np.arange(LAYERS, dtype=np.float32) + 0.5) * (top / LAYERS)).astype(np.float32)
            light = world.surroundings(
                "light", np.full(LAYERS, x / 2, np.float32), np.full(LAYERS, y / 2, np.float32), z
            )
            return light[:, None].astype(np.float64), "of full light"
        if name == GROWTH and name not in world.fields:
            return np.asarray(terrain.land.growth, np.float64), "times the usual"
        field = world.fields[name]
        lattice = field.value.astype(np.float64)
        flat = lattice.mean(axis=1) if world.space.volume else lattice[0]
        return flat, "mol/L" if field.substance else "in each cell"
    raise KeyError(name)
