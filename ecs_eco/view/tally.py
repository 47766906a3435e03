"""Births and deaths of a watched world, counted as they happen, and its story."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.view.story import Story, foods_of

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World
    from ecs_eco.engine.table import Table

CAUSES = 256


class Tally:
    """Counts births and deaths by cause since it was made; it listens, and changes nothing."""

    def __init__(self, world: World, species: list[str]) -> None:
        self.world, self.species = world, species
        self._place = {name: s for s, name in enumerate(species)}
        self.births = np.zeros(len(species), np.int64)
        self.deaths = np.zeros((len(species), CAUSES), np.int64)  # by cause, from 1 as in world.causes
        self.bred = np.zeros(len(species), np.bool_)
        config = None if world.config is None else world.config.model_dump(include={"species"})
        self.foods = foods_of(config)
        self.story = Story(species, self.foods, lambda c: world.causes[c - 1] if c else "unknown")
        self._last = -1
        self._sampled: tuple[int, np.ndarray, np.ndarray] | None = None
        world.on_birth.append(self._was_born)
        world.on_death.append(self._has_died)

    def _was_born(self, table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        s = self._place.get(table.name)
        if s is not None:
            self.births[s] += rows.size
            self.bred[s] |= bool(parents.any())

    def _has_died(self, table: Table, rows: np.ndarray) -> None:
        s = self._place.get(table.name)
        if s is not None:
            self.deaths[s] += np.bincount(table.cause[rows], minlength=CAUSES)

    def passed(self) -> None:
        """Take note of a tick that has passed."""
        if self.world.tick != self._last:
            self._last = self.world.tick
            n = np.array([self.world.tables[name].n for name in self.species], np.int64)
            # the story is of ticks that are over, as the records are
            self.story.note(max(0, self.world.tick - 1), n, self.births, self.deaths, self.bred)

    def rates(self) -> dict[tuple[str, ...], float]:
        """Return births and deaths by cause, a tick, since the last call: points of curves."""
        tick, before = self.world.tick, self._sampled
        self._sampled = tick, self.births.copy(), self.deaths.copy()
        if before is None or tick <= before[0]:
            return {}
        span = tick - before[0]
        point: dict[tuple[str, ...], float] = {}
        for s, name in enumerate(self.species):
            point["births", name] = round(float(self.births[s] - before[1][s]) / span, 4)
            died = self.deaths[s] - before[2][s]
            point["deaths", name] = round(float(died.sum()) / span, 4)
            for cause in np.flatnonzero(self.deaths[s]).tolist():
                point["causes", name, self.world.causes[cause - 1]] = round(float(died[cause]) / span, 4)
        return point

