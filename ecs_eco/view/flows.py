"""Energy flows between species in a live or recorded world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ecs_eco.config.models.reporters import EATEN
from ecs_eco.record.ledger import LEDGER
from ecs_eco.record.recorder import Recorder
from ecs_eco.view.curves import Key

FLOWS = {"taken_in": "taken in", "burnt": "burnt", "given": "given", "lost": "lost"}
"""Ledger columns → their names on the page."""
ENERGY = ("taken in", "burnt")  # flows that have their own chart
PLACES = [LEDGER.index(name) for name in FLOWS]


def of_world(recorder: Recorder | None) -> dict[Key, float]:
    """Return the recorded energy flows of a live world so far: sums ("flows", species, name) and, for the
    energy taken in and burned by eaters, also ("energy", species, name)."""
    if recorder is None:
        return {}
    intake = recorder.intake
    columns = [*FLOWS, *(EATEN + food for food in intake.foods)]
    so_far = np.hstack([intake.flows[:, PLACES], intake.total]).T
    sums = {name: np.stack([0 * of, of]) for name, of in zip(columns, so_far, strict=True)}
    eaters = {recorder.names[s]: intake.foods for s in intake.eaters}
    return {key: float(of[-1]) for key, of in of_run(sums, recorder.names, eaters, {}).items()}


def of_run(
    sums: Mapping[str, np.ndarray],
    species: Sequence[str],
    foods: Mapping[str, Sequence[str]],
    meals: Mapping[tuple[str, str], np.ndarray],
) -> dict[Key, np.ndarray]:
    """Return the energy flows of a recorded run at some ticks, f64[ticks] each, as `of_world` does.

    `sums` contains f64[ticks, species] since the first tick, by series column. If there are no columns per
    food,
    energy is divided according to `meals`, the cumulative number of items eaten for each (food, eater) pair.
    """
    out: dict[Key, np.ndarray] = {}
    eaten = [column for column in sums if column.startswith(EATEN)]
    for s, name in enumerate(species):
        columns = FLOWS | dict(zip(eaten, eaten, strict=True))
        flowed = {words: sums[c][:, s] for c, words in columns.items() if c in sums}
        known = [food for food in foods.get(name, []) if (food, name) in meals]
        if known and not eaten and "taken in" in flowed:
            ate = np.array([np.diff(meals[food, name]) for food in known], float)
            shares = by_meals(np.diff(flowed["taken in"]), ate)
            flowed |= {
                EATEN + food: np.append(0, of.cumsum()) for food, of in zip(known, shares, strict=True)
            }
        out |= {("flows", name, words): of for words, of in flowed.items() if of.any()}
        for words in ENERGY:
            if words in flowed and (foods.get(name) or np.diff(flowed[words]).any()):
                out["energy", name, words] = flowed[words]
    return out


def by_meals(taken: np.ndarray, meals: np.ndarray) -> np.ndarray:
    """Divide an eater's energy intake f64[n] among its foods by the number of each eaten, f64[foods, n]."""
    total = meals.sum(axis=0)
    return taken * np.divide(meals, total, out=np.zeros_like(meals), where=total > 0)
