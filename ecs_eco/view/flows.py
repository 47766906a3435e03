"""Who eats how much of whom: energy that went from one to the other, of a living or recorded world."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.config.models.reporters import EATEN
from ecs_eco.ecosystem import World
from ecs_eco.record.ledger import LEDGER

FLOWS = {"taken_in": "taken in", "burnt": "burnt", "given": "given", "lost": "lost"}
"""Columns of the ledger → what pages call them."""
PLACES = [LEDGER.index(name) for name in FLOWS]

Sample = tuple[int, np.ndarray]  # tick, and sums until then
Mark = tuple[np.ndarray, Sample | None]


class Flows:
    """Sums of what was eaten, taken in and burnt, of a living world that has a recorder; it listens only."""

    def __init__(self, world: World) -> None:
        self.world = world
        self._beyond: np.ndarray | float = 0.0  # what the recorder has counted of a time that was taken back
        self._before: Sample | None = None

    def _counted(self) -> np.ndarray:
        intake = self.world.recorder.intake
        return np.hstack([intake.flows[:, PLACES], intake.total])

    def mark(self) -> Mark | None:
        """Return all sums so far, f64[species, flows and foods], and those of the last call of `rates`; None
        without a recorder."""
        return None if self.world.recorder is None else (self._counted() - self._beyond, self._before)

    def go_back(self, mark: Mark | None) -> None:
        """Count on from a mark."""
        if mark is not None:
            self._beyond, self._before = self._counted() - mark[0], mark[1]

    def rates(self) -> dict[tuple[str, ...], float]:
        """Return what flowed, a tick, since the last call: points of curves ("flows", species, what)."""
        mark, tick = self.mark(), self.world.tick
        if mark is None:
            return {}
        sums, before = mark
        self._before = tick, sums
        if before is None or tick <= before[0]:
            return {}
        recorder = self.world.recorder
        assert recorder is not None
        words = [*FLOWS.values(), *(EATEN + food for food in recorder.intake.foods)]
        rate, ever = (sums - before[1]) / (tick - before[0]), sums != 0
        return {
            ("flows", name, words[k]): float(rate[s, k])
            for s, name in enumerate(recorder.names)
            for k in np.flatnonzero(ever[s]).tolist()
        }


def by_meals(taken: np.ndarray, meals: np.ndarray) -> np.ndarray:
    """Share what an eater took in, f64[n], among its foods by how many it ate of each, f64[foods, n]."""
    total = meals.sum(axis=0)
    return taken * np.divide(meals, total, out=np.zeros_like(meals), where=total > 0)


def recorded(
    sums: dict[str, np.ndarray],
    species: list[str],
    ticks: np.ndarray,
    foods: dict[str, list[str]],
    meals: dict[tuple[str, str], np.ndarray],
) -> dict[str, Any]:
    """Return rates between ticks, by species and what flowed.

    `sums` holds f64[ticks, species] since the first tick, by column of the series; where foods have no
    columns there, energy is shared by `meals`, such sums of how many of (food, eater) were eaten.
    """
    span, out = np.diff(ticks), {}
    eaten = [column for column in sums if column.startswith(EATEN)]
    for s, name in enumerate(species):
        columns = FLOWS | dict(zip(eaten, eaten, strict=True))
        rates = {words: np.diff(sums[c][:, s]) / span for c, words in columns.items() if c in sums}
        known = [food for food in foods.get(name, []) if (food, name) in meals]
        if known and not eaten:
            ate = np.array([np.diff(meals[food, name]) / span for food in known])
            rates |= {
                EATEN + food: share
                for food, share in zip(known, by_meals(rates["taken in"], ate), strict=True)
            }
        said = {
            words: [None, *(float(f"{v:.5g}") for v in values)]
            for words, values in rates.items()
            if values.any()
        }
        if said:
            out[name] = said
    return out
