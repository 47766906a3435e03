"""Mate choice: which of the candidates in reach an organism mates with."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence

CHOICES = ("nearest", "random", "richest", "oldest")
"""The rules that mating knows, by their numbers."""

Numbers = Sequence[float]


def nearest(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return the nearest candidate; ties go to the lowest uid."""
    return min(zip(distance, candidates, strict=True))[1]


def any_one(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return a candidate drawn from Python's random numbers, whatever the order of the list."""
    return random.choice(sorted(candidates))


def richest(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return the candidate with the most energy; ties go to the lowest uid."""
    return min(zip((-e for e in energy), candidates, strict=True))[1]


def oldest(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return the oldest candidate; ties go to the lowest uid."""
    return min(zip((-a for a in age), candidates, strict=True))[1]


RULES: dict[str, Callable[..., int]] = dict(zip(CHOICES, (nearest, any_one, richest, oldest), strict=True))
"""By name: select_mate(chooser, candidates, distance, energy,
age) of uids and a number for each candidate; returns a uid."""
