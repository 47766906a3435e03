"""Continuous actions of a species: between which numbers they are, and what becomes of what was drawn."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ecs_eco.learning.continuous import in_units


class Ranges:
    """Least and most of each continuous action, in the order of the columns of Motor.

    Made of group: ((least, most), column of its action in the decision, the number where nothing chooses one,
    None for that nearest to 0).
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

    def command(self, numbers: np.ndarray | None, shift: np.ndarray | None) -> np.ndarray:
        """Return what is carried out, f32[n or 1, k]: numbers f32[n, k] of the policy in units of half the
        range (None: no policy), shifted by the reflex f32[n, k], and held within the range."""
        chosen = self.rest[None] if numbers is None else in_units(numbers, self.low, self.high)
        return chosen if shift is None else np.clip(chosen + shift, self.low, self.high)
