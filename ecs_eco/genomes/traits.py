"""A trait: a value of a species that a gene may replace, and the column of individual values."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

Kind = Literal["number", "whole", "sign", "weights"]
Shapes = Sequence[tuple[int, ...]]


@dataclass(frozen=True)
class Trait:
    """A value of a species that a gene may replace, and its column: component.field, or its entry `index`."""

    name: str
    component: str
    field: str
    index: int | None
    default: float  # the species' own value
    low: float  # natural bounds
    high: float
    kind: Kind
    unit: str
    text: str

    def nearest(self, values: np.ndarray) -> np.ndarray:
        """Return the possible values nearest to others: within limits, rounded if integers; of NaN, the
        species' own."""
        values = np.where(np.isnan(values), self.default, np.clip(values, self.low, self.high))
        return np.rint(values) if self.kind in ("whole", "sign") else values
