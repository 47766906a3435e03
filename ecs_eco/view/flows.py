"""Energy flows between species in the series of a world."""

from collections.abc import Mapping, Sequence

import numpy as np

from ecs_eco.config.models.reporters import DIED, EATEN

FLOWS = {"taken_in": "taken in", "burnt": "burnt", "given": "given", "lost": "lost"}
"""Ledger columns → their names on the page."""
ENERGY = ("taken in", "burnt")  # flows that have their own chart
BY = DIED + "eaten by "


def of_run(
    sums: Mapping[str, np.ndarray], species: Sequence[str], foods: Mapping[str, Sequence[str]]
) -> dict[tuple[str, ...], np.ndarray]:
    """Return the energy flows up to some ticks, f64[ticks] each: ("flows", species, name) and, for the energy
    taken in and burned by eaters, also ("energy", species, name).

    `sums` contains the columns of the series as f64[ticks, species], summed since the first tick; the first
    row is 0. Without columns per food, an eater's energy is divided among its foods by the number of each eaten.
    """
    out: dict[tuple[str, ...], np.ndarray] = {}
    eaten = {column: column for column in sums if column.startswith(EATEN)}
    for s, name in enumerate(species):
        flowed = {words: sums[c][:, s] for c, words in (FLOWS | eaten).items() if c in sums}
        known = [food for food in foods.get(name, []) if BY + name in sums and food in species]
        if known and not eaten and "taken in" in flowed:
            ate = np.array([np.diff(sums[BY + name][:, species.index(food)]) for food in known], float)
            shares = by_meals(np.diff(flowed["taken in"]), ate)
            flowed |= {
                EATEN + food: np.append(0, of.cumsum()) for food, of in zip(known, shares, strict=True)
            }
        out |= {("flows", name, words): of for words, of in flowed.items() if of.any()}
        for words in ENERGY:
            if words in flowed and (foods.get(name) or flowed[words].any()):
                out["energy", name, words] = flowed[words]
    return out


def by_meals(taken: np.ndarray, meals: np.ndarray) -> np.ndarray:
    """Divide an eater's energy intake f64[n] among its foods by the number of each eaten, f64[foods, n]."""
    total = meals.sum(axis=0)
    return taken * np.divide(meals, total, out=np.zeros_like(meals), where=total > 0)
