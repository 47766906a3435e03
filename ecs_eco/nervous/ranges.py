"""Ranges of a species' continuous actions, and the conversion of drawn numbers to executed ones."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.genomes.own_values import own_values
from ecs_eco.learning.continuous import in_units

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


class Ranges:
    """The limits of each continuous action, in the order of Motor's columns.

    Built from a dict: group → ((lowest, highest), column of its action in the decision, number if no choice
    is made). If that number is None, the one nearest to 0 is used.
    """

    def __init__(self, ranges: Mapping[str, tuple[tuple[float, float], int, Any]]) -> None:
        self.groups = tuple(ranges)
        self.columns = np.array([column for _, column, _ in ranges.values()], np.int64)
        ends = np.array([end for end, _, _ in ranges.values()], np.float32).reshape(-1, 2)
        self.low, self.high = ends[:, 0].copy(), ends[:, 1].copy()
        rest = [0.0 if given is None else given for _, _, given in ranges.values()]
        self.rest = np.clip(np.array(rest, np.float32), self.low, self.high)

    def __len__(self) -> int:
        return len(self.groups)

    def of(self, table: Table, rows: np.ndarray) -> Ranges:
        """Return these ranges or, if genes code for any of their numbers, the ranges of rows i64[n]: low,
        high and rest f32[n, k]. If a genome codes for a lower limit above the upper limit, the upper limit is
        used for both."""
        keys = {
            f"actions.{group}.continuous.{end}": column[k]
            for k, group in enumerate(self.groups)
            for end, column in ((0, self.low), (1, self.high))
        }
        keys |= {f"default_action.{group}": self.rest[k] for k, group in enumerate(self.groups)}
        values = own_values(table, keys)
        if not self.groups or not isinstance(values[0], np.ndarray):
            return self
        each, k, own = np.stack([value[rows] for value in values], 1), len(self.groups), copy(self)
        own.high = each[:, 1 : 2 * k : 2]
        own.low = np.minimum(each[:, 0 : 2 * k : 2], own.high)
        own.rest = np.clip(each[:, 2 * k :], own.low, own.high)
        return own

    def command(self, numbers: np.ndarray | None, shift: np.ndarray | None) -> np.ndarray:
        """Return the executed numbers f32[n or 1, k]: the policy's numbers f32[n, k] in units of half the
        range (None: no policy), shifted by the reflex f32[n, k] and clipped to the range."""
        chosen = np.atleast_2d(self.rest) if numbers is None else in_units(numbers, self.low, self.high)
        return chosen if shift is None else np.clip(chosen + shift, self.low, self.high)
