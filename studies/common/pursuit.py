"""Movements of hunters and prey by distance to the nearest animal of the other species: how many run, and in
which direction."""

from __future__ import annotations

from typing import Any

import numpy as np

EDGES = np.arange(0.0, 13.0)  # [m]
COLUMNS = ("n", "run", "toward, running", "toward")  # counts, and sums of cosines


class Pursuit:
    """Counts in distance bins with edges EDGES: deer by distance to the nearest wolf, and wolves by distance
    to the nearest deer."""

    def __init__(self, world: Any) -> None:
        self.world = world
        self.counts = {name: np.zeros((len(EDGES) - 1, len(COLUMNS))) for name in ("deer", "wolf")}
        self.walk = {name: world.config.species[name].locomotion.speed["walk"] for name in self.counts}

    def look(self) -> None:
        """Count all living animals."""
        for name, other in (("deer", "wolf"), ("wolf", "deer")):
            if self.world.tables[name].n and self.world.tables[other].n:
                distance, cosine, speed = nearest(self.world, name, other)
                runs, at = speed > 1.05 * self.walk[name], np.digitize(distance, EDGES) - 1
                for i, values in enumerate((np.ones(len(at)), runs, runs * cosine, cosine)):
                    self.counts[name][:, i] += np.bincount(at, values, len(EDGES))[: len(EDGES) - 1]

    def as_lists(self) -> dict[str, list[list[float]]]:
        """Return the counts as JSON-compatible data."""
        return {name: counts.round(3).tolist() for name, counts in self.counts.items()}


def nearest(world: Any, name: str, other: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return, for each animal, the distance f64[n] [m] to the nearest animal of the other species, the cosine
    of the angle between its heading and that direction, and its speed [m/s]."""
    from scipy.spatial import KDTree

    from ecs_eco.components import Position, Velocity

    size = np.array(world.config.space.size[:2], float)
    places = {}
    for species in (name, other):
        table = world.tables[species]
        rows, p = table.by_uid(), table[Position]
        places[species] = np.stack([p.x[rows], p.y[rows]], 1).astype(float) % size
    table = world.tables[name]
    rows = table.by_uid()
    distance, which = KDTree(places[other], boxsize=size).query(places[name])
    way = places[other][which] - places[name]
    way -= size * np.round(way / size)
    heading = table[Position].heading[rows].astype(float)
    cosine = (np.cos(heading) * way[:, 0] + np.sin(heading) * way[:, 1]) / np.maximum(distance, 1e-9)
    return distance, cosine, table[Velocity].speed[rows].astype(float)


def share(counts: list[list[float]], column: str, low: float, high: float) -> float:
    """Return a sum over animals at distances from `low` to `high` [m], divided by their number or, for
    "toward, running", by the number of running animals. NaN if there are no such animals."""
    c = np.array(counts)[(EDGES[:-1] >= low) & (EDGES[1:] <= high)].sum(0)
    of = c[COLUMNS.index("run" if column == "toward, running" else "n")]
    return float(c[COLUMNS.index(column)] / of) if of else float("nan")
