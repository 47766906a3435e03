"""Measures of a predator-prey cycle that apply to any two series: in years or ticks, of pelts or animals."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from ecs_eco.analysis.signature import cycle, period_of

MEASURES = ("lag", "regularity", "prey swing", "predator swing")
"""Measures independent of the time unit."""


@dataclass(frozen=True)
class Signature:
    """The cycle of a pair of series."""

    period: float  # [samples]
    lag: float  # predator's lag behind its prey, as a share of the period in [0, 1)
    regularity: float  # geometric mean of both series' shares of variance explained by a wave of this period
    prey_swing: float  # standard deviation of the detrended log10 numbers
    predator_swing: float

    def as_dict(self) -> dict[str, float]:
        """Return the measures by name, with spaces as in MEASURES."""
        return {name.replace("_", " "): value for name, value in asdict(self).items()}


def signature(prey: np.ndarray, predator: np.ndarray) -> Signature:
    """Return the cycle of prey and predator series, each f[n], sampled at the same times.

    Raises a ValueError if the series differ in length or cannot be measured.
    """
    if len(prey) != len(predator):
        raise ValueError(
            f"{len(prey)} numbers of the prey, {len(predator)} of the predator; expected the same times"
        )
    both = cycle(prey, predator)
    return Signature(
        both.period, float(both.phases[1]), float(np.sqrt(both.shares.prod())), *map(float, both.swings)
    )


def windows(prey: np.ndarray, predator: np.ndarray, samples: int, per_period: float) -> list[Signature]:
    """Return the cycle for consecutive windows of a long pair of series f[ticks].

    Each window is sampled like a short series: it has `samples` numbers, `per_period` of them in each period
    of the long series. Windows in which a species is absent throughout are omitted.
    """
    step = period_of(prey, predator) / per_period
    length = int(np.floor(step * samples))
    at = np.floor(step * np.arange(samples)).astype(int)
    starts = range(0, len(prey) - length + 1, length)
    pairs = [(np.asarray(prey)[s + at], np.asarray(predator)[s + at]) for s in starts]
    return [signature(x, y) for x, y in pairs if x.any() and y.any()]
