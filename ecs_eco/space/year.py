"""The year: how much of it has passed, and its effect on temperature."""

import math

from ecs_eco.compiled.elementary import scalars


class Year:
    """A year of `length` [s]; a share of 0 is the spring equinox, 0.25 is midsummer and 0.5 is the autumn
    equinox; see `ecs_eco.config.models.water.Year` for the values."""

    def __init__(
        self, length: float, start: float = 0.0, temperature: float = 0.0, warmest: float = 0.25
    ) -> None:
        self.length, self.start, self.temperature, self.warmest = length, start, temperature, warmest

    def share(self, time: float) -> float:
        """Return how much of the year has passed at a given time [s]: from 0 to 1."""
        return (time / self.length + self.start) % 1.0

    def warming(self, time: float) -> float:
        """Return the deviation [K] from the annual mean temperature at a given time [s], a sine wave."""
        return self.temperature * scalars.cos(2 * math.pi * (self.share(time) - self.warmest))
