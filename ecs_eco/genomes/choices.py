"""Mate choice: the selection of a mate from the candidates in reach."""

import random
from collections.abc import Callable, Sequence

CHOICES = ("nearest", "random", "richest", "oldest")
"""The rules of mate choice; a rule's number is its index."""

Numbers = Sequence[float]


def nearest(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return the nearest candidate; if several are tied, one of them at random."""
    return _first(distance, candidates)


def any_one(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return a candidate drawn with Python's random number generator; the order of the list does not matter."""
    return random.choice(sorted(candidates))


def richest(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return the candidate with the most energy; if several are tied, one of them at random."""
    return _first([-e for e in energy], candidates)


def oldest(chooser: int, candidates: Sequence[int], distance: Numbers, energy: Numbers, age: Numbers) -> int:
    """Return the oldest candidate; if several are tied, one of them at random."""
    return _first([-a for a in age], candidates)


def _first(values: Numbers, candidates: Sequence[int]) -> int:
    """Return the candidate with the lowest value; if several are tied, one of them at random."""
    least = min(values)
    return random.choice(sorted(c for v, c in zip(values, candidates, strict=True) if v == least))


RULES: dict[str, Callable[..., int]] = dict(zip(CHOICES, (nearest, any_one, richest, oldest), strict=True))
"""By name: select_mate(chooser, candidates, distance, energy, age) → uid; one number per candidate."""
