"""Births and deaths of a watched world, counted as they happen, and its story."""

from __future__ import annotations

from copy import copy
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Metabolism
from ecs_eco.view.story import Story, foods_of

if TYPE_CHECKING:
    from ecs_eco.ecosystem import World
    from ecs_eco.engine.table import Table

CAUSES = 256
KEPT = ("births", "deaths", "bred", "_last", "_gone", "_sampled")
EVERY = 5  # ticks from one look at the numbers to the next; extinctions are seen at once


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
        self._tables = [world.tables[name] for name in species]
        self._last, self._gone = -EVERY, -1  # when the story was told last, and how many were extinct then
        self._sampled: tuple[int, np.ndarray, np.ndarray] | None = None
        world.on_birth.append(self._was_born)
        world.on_death.append(self._has_died)

    def _was_born(self, table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        s = self._place.get(table.name)
        if s is not None:
            self.births[s] += rows.size
            self.bred[s] = self.bred[s] or parents.any()

    def _has_died(self, table: Table, rows: np.ndarray) -> None:
        s = self._place.get(table.name)
        if s is not None:
            self.deaths[s] += np.bincount(table.cause[rows], minlength=CAUSES)

    def passed(self) -> None:
        """Take note of a tick that has passed."""
        n = [table.n for table in self._tables]
        gone = n.count(0)
        if self.world.tick >= self._last + EVERY or gone != self._gone:
            self._last, self._gone = self.world.tick, gone
            over = max(0, self.world.tick - 1)  # as in the records: the last tick that is over
            self.story.note(over, np.array(n, np.int64), self.births, self.deaths, self.bred)

    def _energy(self, name: str, table: Table) -> dict[tuple[str, ...], float]:
        """Return what the living of a species took in and burnt in the last tick [energy]."""
        if Metabolism not in table or not table.n:
            return {}
        m, rows = table[Metabolism], table.rows()
        return {("energy", name, "taken in"): float(m.taken[rows].sum(dtype=np.float64)),
                ("energy", name, "burnt"): float(m.burnt[rows].sum(dtype=np.float64))}

    def mark(self) -> dict[str, Any]:
        """Return what has been counted and told so far."""
        return {name: copy(getattr(self, name)) for name in KEPT} | {"story": self.story.mark()}

    def go_back(self, mark: dict[str, Any]) -> None:
        """Count and tell on from a mark."""
        for name in KEPT:
            setattr(self, name, copy(mark[name]))
        self.story.go_back(mark["story"])

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
            point |= self._energy(name, self._tables[s])
            for cause in np.flatnonzero(self.deaths[s]).tolist():
                point["causes", name, self.world.causes[cause - 1]] = round(float(died[cause]) / span, 4)
        return point

