"""Individual fertility by age and season."""

from ecs_eco.engine.schema import component, f32


@component
class Breeding:
    """The course of fertility over a life and over a year."""

    peak: f32.within(0, 1) = 1.0  # fertility at the prime, in season
    maturity: f32 = 0.0  # [s] age at which fertility begins
    prime: f32 = 0.0  # [s] age of peak fertility
    end: f32 = 1.0e30  # [s] age at which fertility ends; 1e30: never
    season: f32 = 0.0  # time of year of peak fertility, as a fraction of a year
    width: f32.within(0, 1e30) = 0.0  # standard deviation of the season, as a fraction of a year; 0: all year
