"""Uids: lookups, and worlds that exchange entities, where each island counts from a different start."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np

Uid = TypeVar("Uid", int, np.ndarray)

BITS = 48  # each island can assign 2.8e14 uids
MOST_ISLANDS = 32  # keeps uids below 2^53, up to which JSON and JavaScript represent integers exactly


def first_uid(island: int) -> int:
    """Return the first uid of an island; islands are numbered from 0."""
    return (island << BITS) + 1


def island_of(uid: Uid) -> Uid:
    """Return the number of the island where an entity was born, from its uid or uids u64[n]."""
    return uid >> (BITS if isinstance(uid, int) else uid.dtype.type(BITS))


def is_given(uid: Uid, next_uid: int) -> Any:
    """Return which uids u64[n] were assigned before `next_uid`, or by other islands: bool[n]."""
    return (uid < next_uid) | (island_of(uid) != island_of(next_uid))


def matched(known: np.ndarray, uids: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the index of each uid in `known`, which is ascending, and whether it is there: i64[n], bool[n]."""
    at = np.minimum(np.searchsorted(known, uids), max(known.size - 1, 0))
    return at, known[at] == uids if known.size else np.zeros(uids.size, np.bool_)
