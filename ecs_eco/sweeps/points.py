"""The points of a sweep: every set of values that it runs a world with."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from ecs_eco.config import WorldConfig
from ecs_eco.config.models.search import Range
from ecs_eco.config.ranges import Key, key_of, real_key
from ecs_eco.engine.errors import Problem
from ecs_eco.sweeps.plan import Hypercube, PlanFile

DIGITS = 4  # significant ones, of drawn numbers


@dataclass(frozen=True)
class Entry:
    """One value, and where it stands in the plan."""

    value: Any
    place: Key


Point = dict[str, Entry]


def points_of(file: PlanFile, base: WorldConfig) -> Iterator[Point]:
    """Yield every point of a plan: lists, hypercube and grid crossed, the last key of the grid fastest."""
    plan = file.plan
    factors: list[Sequence[Point]] = []
    if plan.list:
        factors.append(
            [
                {name: Entry(value, file.place(f"list/{i}", name)) for name, value in entry.items()}
                for i, entry in enumerate(plan.list)
            ]
        )
    if plan.latin_hypercube is not None:
        factors.append(_drawn(file, plan.latin_hypercube, base))
    for name, values in (plan.grid or {}).items():
        place = file.place("grid", name)
        factors.append([{name: Entry(value, (*place, i))} for i, value in enumerate(values)])
    for parts in product(*factors):
        yield {name: entry for part in parts for name, entry in part.items()}


def number_of_points(file: PlanFile) -> int:
    """Return how many points a plan has."""
    plan = file.plan
    n = len(plan.list or [()]) * (plan.latin_hypercube.points if plan.latin_hypercube else 1)
    for values in (plan.grid or {}).values():
        n *= len(values)
    return n


def problems_of_ranges(file: PlanFile, base: WorldConfig) -> Iterator[Problem]:
    """Yield what is wrong with the ranges of a plan's hypercube."""
    cube = file.plan.latin_hypercube
    data = base.model_dump() if cube is not None else {}
    for name, span in (cube.ranges if cube is not None else {}).items():
        place, (low, high) = file.place("latin_hypercube/ranges", name), span.search
        _, value, wrong = real_key(data, key_of(name))
        if wrong is not None:
            yield wrong.moved(key=place, value=name)
        elif value is not None and (isinstance(value, bool) or not isinstance(value, int | float)):
            yield Problem(
                place,
                f"is a range, and its key holds no number: {value!r}",
                span.search,
                "the key of a number",
            )
        elif not low < high:
            yield Problem(place, "is no range", span.search, "[low, high] with low < high")
        elif span.scale == "log" and low <= 0:
            yield Problem(place, "cannot be taken on a log scale", span.search, "low > 0")


def _drawn(file: PlanFile, cube: Hypercube, base: WorldConfig) -> list[Point]:
    """Return the points of a Latin hypercube (McKay, Beckman and Conover 1979), in the order of drawing."""
    from scipy.stats import qmc

    shares = qmc.LatinHypercube(len(cube.ranges), rng=cube.seed).random(cube.points)
    data = base.model_dump()
    points: list[Point] = [{} for _ in range(cube.points)]
    for column, (name, span) in zip(shares.T, cube.ranges.items(), strict=True):
        value = real_key(data, key_of(name))[1]
        whole = all(isinstance(x, int) for x in (value, *span.search))
        place = file.place("latin_hypercube/ranges", name)
        for point, share in zip(points, column, strict=True):
            point[name] = Entry(_number(span, float(share), whole), place)
    return points


def _number(span: Range, share: float, whole: bool) -> float:
    """Return the number at a share of a range; whole ones have equal chances, ends included."""
    low, high = span.search
    if whole and span.scale == "linear":
        return low + int(share * (high - low + 1))
    if span.scale == "log":
        drawn = float(np.exp(np.log(low) + share * (np.log(high) - np.log(low))))
    else:
        drawn = low + share * (high - low)
    return round(drawn) if whole else min(max(float(f"{drawn:.{DIGITS}g}"), low), high)
