"""Traits: values of a species that genes can replace, and the columns of individual values."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

Kind = Literal["number", "whole", "sign", "weights"]
Shapes = Sequence[tuple[int, ...]]


@dataclass(frozen=True)
class Trait:
    """A value of a species that a gene can replace, and its column: component.field, or entry `index` of that
    field."""

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
        """Return the nearest possible values: within the limits, and rounded if they are integers; NaN
        becomes the default."""
        values = np.where(np.isnan(values), self.default, np.clip(values, self.low, self.high))
        return np.rint(values) if self.kind in ("whole", "sign") else values
