"""Deaths of animals in the last ticks, with their places: what a page marks in the scene."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from ecs_eco.components import Position, Velocity
from ecs_eco.ecosystem import World
from ecs_eco.engine.table import Table
from ecs_eco.view.recording import Recording

TICKS = 5  # that a mark stays
MOST = 100  # marks in a message, the latest
Fate = tuple[int, int, int, float, float, float, int]
"""Tick, species (its number), uid, x, y, z [m], uid of the killer or 0."""


class Fates:
    """Listens to the deaths of animals of a living world; plants die too often to be marked."""

    def __init__(self, world: World, species: list[str]) -> None:
        self.world = world
        self._number = {name: i for i, name in enumerate(species) if Velocity in world.tables[name]}
        self._deaths: deque[tuple[int, int, *tuple[np.ndarray, ...]]] = deque(maxlen=256)
        world.on_death.append(self._has_died)

    def _has_died(self, table: Table, rows: np.ndarray) -> None:
        number = self._number.get(table.name)
        if number is not None:
            p, rows = table[Position], rows[:MOST]
            self._deaths.append(
                (
                    self.world.tick,
                    number,
                    table.uid[rows],
                    p.x[rows],
                    p.y[rows],
                    p.z[rows],
                    table.killer[rows],
                )
            )

    def go_back(self, tick: int) -> None:
        """Forget the deaths of a tick and of later ones."""
        while self._deaths and self._deaths[-1][0] >= tick:
            self._deaths.pop()

    def since(self, tick: int) -> list[Fate]:
        """Return the deaths after a tick, of the last five ticks at the most."""
        found: list[Fate] = []
        for when, number, uids, *places, killers in reversed(self._deaths):
            if when < max(tick, self.world.tick - TICKS) or len(found) >= MOST:
                break
            x, y, z = np.array(places, np.float64).round(2).tolist()
            found += zip(
                [when] * uids.size,
                [number] * uids.size,
                uids.tolist(),
                x,
                y,
                z,
                killers.tolist(),
                strict=True,
            )
        return found[:MOST]


def recorded(recording: Recording, moving: set[str], after: int, tick: int) -> list[Fate]:
    """Return the same of a recorded run, of the ticks after `after` up to `tick`."""
    names = ("tick", "species", "uid", "x", "y", "z", "killer")
    columns: Any = recording.deaths.between(max(after + 1, tick - TICKS + 1), tick, names)
    animals = [i for i, name in enumerate(recording.species) if name in moving]
    rows = np.flatnonzero(np.isin(columns["species"], animals))[-MOST:]
    x, y, z = (columns[axis].astype(np.float64).round(2) for axis in "xyz")
    return [
        (
            int(columns["tick"][r]),
            int(columns["species"][r]),
            int(columns["uid"][r]),
            float(x[r]),
            float(y[r]),
            float(z[r]),
            int(columns["killer"][r]),
        )
        for r in rows.tolist()
    ]
