"""Functions that follow animals in a running world, tick by tick."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.analysis.tracks import Placed, Record, Tracks, shortest, tracks_of
from ecs_eco.components import Position
from ecs_eco.space.nearest import nearest

if TYPE_CHECKING:
    from ecs_eco import World


def follow(
    world: World,
    ticks: int,
    prey: str,
    predator: str,
    within: float = 10.0,
    each: Callable[[World], None] | None = None,
) -> Tracks:
    """Run a world for some ticks; record the actions of each prey animal and its nearest predator within 10
    m.

    `each(world)` is called before each tick, for example to move objects as an experimenter would.
    """
    top = np.full(1, np.nextafter(world.space.lengths[2], np.float32(0)), np.float32)
    records: list[Record] = []
    light = np.empty(ticks)
    for tick in range(ticks):
        if each is not None:
            each(world)
        light[tick] = world.surroundings("light", top * 0, top * 0, top)[0]
        before = _where(world, prey)
        distance, offset = _nearest(world, prey, predator, within)
        world.step()
        records.append((before, distance, offset, _where(world, prey)))
    return tracks_of(records, light, world.space, world.dt)


def _where(world: World, name: str) -> Placed:
    table = world.tables[name]
    rows, p = table.by_uid(), table[Position]
    return table.uid[rows], np.stack([p.x[rows], p.y[rows], p.z[rows]], 1).astype(float)


def _nearest(world: World, prey: str, predator: str, within: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the distance f64[n] and offset f64[n, 3] from each prey animal to the nearest predator, in uid
    order."""
    mine, other = world.index(world.tables[prey]), world.index(world.tables[predator])
    target, square = np.empty(mine.n, np.int32), np.empty(mine.n, np.float32)
    nearest(mine, other, within, target, square)
    order = np.argsort(mine.uid[: mine.n])
    target, j = target[order], np.maximum(target[order], 0)
    d = np.zeros((mine.n, 3))
    if other.n:
        axes = ((other.x, mine.x), (other.y, mine.y), (other.z, mine.z))
        d = np.stack([t[j] - o[order] for t, o in axes], 1).astype(float)
    return np.where(target >= 0, np.sqrt(square[order]), np.inf), shortest(world.space, d)
