"""Mate choice: the selection of a mate among the candidates in reach."""

import random
from collections.abc import Callable, Sequence

CHOICES = ("nearest", "random", "richest", "oldest")
"""The rules of mate choice, by their numbers."""

Numbers = Sequence[float]


def nearest(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return the nearest candidate; one at random if several are equal."""
    return _first(distance, candidates)


def any_one(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return a candidate drawn from Python's random numbers, whatever the order of the list."""
    return random.choice(sorted(candidates))


def richest(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return the candidate with the most energy; one at random if several are equal."""
    return _first([-e for e in energy], candidates)


def oldest(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return the oldest candidate; one at random if several are equal."""
    return _first([-a for a in age], candidates)


def _first(values: Numbers, candidates: Sequence[int]) -> int:
    """Return the candidate with the lowest value, one at random if several have it."""
    least = min(values)
    return random.choice(sorted(c for v, c in zip(values, candidates, strict=True) if v == least))


RULES: dict[str, Callable[..., int]] = dict(zip(CHOICES, (nearest, any_one, richest, oldest), strict=True))
"""By name: select_mate(chooser, candidates, distance, energy,
age) of uids and a number for each candidate; returns a uid."""
