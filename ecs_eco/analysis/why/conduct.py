"""Behaviour: distances to enemies and food compared with chance, movement and meals."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ecs_eco.analysis.why.case import Case

MOST = 2000  # organisms of one snapshot from which distances are measured


def conduct(case: Case, species: str, first: int, last: int) -> dict[str, Any]:
    """Behaviour of one species in the rows first … last − 1 of the series, per head and tick;
    None where it was not recorded."""
    span = slice(first, last)
    heads = float(case.series.of(species)[span].sum())
    if not heads:
        return {}
    per = {name: float(case.flow(species, name)[span].sum() / heads) for name in ("taken_in", "burnt")}
    return {
        "meals": float(case.meals(species)[span].sum() / heads),
        "intake": per["taken_in"],
        "burnt": per["burnt"],
        "effort": effort(case, species, per["burnt"]),
        "enemies": {e: distance(case, species, e, first, last) for e in case.eaters(species)},
        "food": {f.eats: distance(case, species, f.eats, first, last) for f in case.diet(species)},
    }


def effort(case: Case, species: str, burnt: float) -> float | None:
    """The cost of locomotion, as a share of using the costliest gait all the time; None if moving is free."""
    values, dt = case.of(species), case.series.dt
    costs = ((values.get("locomotion") or {}).get("cost") or {}).values()
    basal = (values.get("metabolism") or {}).get("basal", 0.0)
    dearest = max(costs, default=0.0)
    return float(np.clip((burnt / dt - basal) / dearest, 0, 1)) if dearest else None


def distance(case: Case, species: str, other: str, first: int, last: int) -> dict[str, float] | None:
    """Mean distance [m] from one of a species to the nearest of another,
    and as a multiple of chance (Clark & Evans 1954).

    Over the snapshots between two rows; 1 is the value at random places,
    above 1 they avoid each other. None if no snapshot has both.
    """
    a, b = case.snapshots.get(species), case.snapshots.get(other)
    size = case.config.get("space", {}).get("size")
    if a is None or b is None or not size:
        return None
    ticks = case.series.ticks
    low, high = ticks[first], ticks[min(last, len(ticks)) - 1]
    common = [t for t in np.intersect1d(a["tick"], b["tick"]) if low <= t <= high]
    means, ratios = [], []
    for t in common[:: max(1, len(common) // 20)]:
        here, there = (_places(table, t, len(size)) for table in (a, b))
        nearest = _nearest(
            here[:: max(1, len(here) // MOST)],
            there,
            size,
            case.config["space"].get("edges", "torus") == "torus",
        )
        means.append(nearest)
        ratios.append(nearest / chance(len(there), size))
    return {"mean": float(np.mean(means)), "to_chance": float(np.mean(ratios))} if means else None


def chance(n: int, size: list[float]) -> float:
    """Expected distance [m] to the nearest of n at random places: 1 / (2 √density) in a plane,
    Γ(4/3) (3 / 4π density)^⅓ in a volume."""
    density = n / math.prod(size)
    return (
        0.5 / math.sqrt(density)
        if len(size) == 2
        else math.gamma(4 / 3) * (3 / (4 * math.pi * density)) ** (1 / 3)
    )


def _places(table: Mapping[str, np.ndarray], tick: int, dims: int) -> np.ndarray:
    rows = table["tick"] == tick
    return np.stack([table[axis][rows] for axis in "xyz"[:dims]], 1).astype(float)


def _nearest(here: np.ndarray, there: np.ndarray, size: list[float], torus: bool) -> float:
    """Mean distance from `here` to the nearest of `there`; a torus has no edges in the plane,
    a volume has a floor and a surface."""
    from scipy.spatial import cKDTree

    if not torus:
        return float(cKDTree(there).query(here)[0].mean())
    box = [*size[:2], *(4 * s for s in size[2:])]  # the third axis does not wrap
    tree = cKDTree(there % box, boxsize=box)
    return float(tree.query(here % box)[0].mean())
