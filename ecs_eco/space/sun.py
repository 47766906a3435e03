"""The sun's elevation, and the light of the sun and the moon."""

import math

from ecs_eco.compiled.elementary import scalars

HALF_DAY = 0.5


class Sun:
    """Light at the surface, relative to the sun at the zenith; see `ecs_eco.config.models.water.Sun`."""

    def __init__(
        self,
        kind: str = "natural",
        day: float = 86_400.0,
        start: float = 0.0,
        latitude: float = 0.0,
        declination: float = 0.0,
        year: float | None = None,
        moon: float = 0.0,
        spring: float = 0.0,
    ) -> None:
        self.kind, self.day, self.start, self.year, self.moon = kind, day, start, year, moon
        self.spring = spring  # share of the year, counted from spring, that has passed at the start
        self.latitude, self.declination = math.radians(latitude), math.radians(declination)

    def season(self, time: float) -> float:
        """Return the declination of the sun [rad] at a given time [s]: sinusoidal over a year (Cooper 1969)."""
        return (
            self.declination
            if self.year is None
            else self.declination * scalars.sin(2 * math.pi * (time / self.year + self.spring))
        )

    def light(self, time: float) -> float:
        """Return the light at a given time [s]; seasons apply even without a daily cycle."""
        season = self.season(time)
        if self.kind == "constant":
            return daily_mean(self.latitude, season) + self.moon * daily_mean(self.latitude, -season)
        share = time / self.day + self.start + (HALF_DAY if self.kind == "inverted" else 0.0)
        height = sine_of_elevation(share, self.latitude, season)
        return max(height, 0.0) + self.moon * max(-height, 0.0)


def sine_of_elevation(share: float, latitude: float, declination: float) -> float:
    """Return the sine of the sun's elevation when a share of the day has passed since midnight; angles are in
    [rad] (Iqbal 1983, eq. 1.5.1)."""
    hour_angle = 2 * math.pi * (share - HALF_DAY)
    return scalars.sin(latitude) * scalars.sin(declination) + scalars.cos(latitude) * scalars.cos(
        declination
    ) * scalars.cos(hour_angle)


def daily_mean(latitude: float, declination: float) -> float:
    """Return the daily mean of the sine of the sun's elevation, taken as 0 at night (Iqbal 1983, eq. 4.2.15)."""
    up = scalars.sin(latitude) * scalars.sin(declination)
    swing = scalars.cos(latitude) * scalars.cos(declination)
    # [rad] hour angle; π in the polar day, 0 in the polar night
    sunset = math.pi if up >= swing else (0.0 if up <= -swing else scalars.acos(-up / swing))
    return (sunset * up + swing * scalars.sin(sunset)) / math.pi
