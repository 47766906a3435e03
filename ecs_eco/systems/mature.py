"""Fertility varies with age and season."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Biology, Breeding
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System

if TYPE_CHECKING:
    from ecs_eco.config.features.life_history import Breeding as Season
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

NEVER = 1e30  # [s] an age that no organism reaches
EDGE = (
    1e-3  # minimum distance of the prime from maturity and from the end, as a share of the time between them
)


class Fertility(NamedTuple):
    """Fertility by age and season, for kernels: f32[rows], or arrays of length 1."""

    peak: np.ndarray
    maturity: np.ndarray  # [s]
    prime: np.ndarray  # [s]
    end: np.ndarray  # [s]
    season: np.ndarray  # share of the year
    width: np.ndarray  # share of the year, 0: no season


class Mature(System):
    """An organism becomes fertile at maturity; it is most fertile in its prime and least fertile in old age
    and out of season.

    When a share u of the time from maturity to the end of fertility has passed, fertility is proportional to
    u^(3 m) (1 − u)^(3 (1 − m)), a beta curve with its peak at m. With m = 1/3, this is Brass's polynomial u
    (1 − u)² (Brass 1975, Gage 2001). The season multiplies fertility by exp(κ (cos 2π(t − season) − 1)), the
    von Mises curve, where t is the elapsed share of the year and κ = 1/(2π width)².
    """

    needs = (Biology,)
    phase = "environment"
    submodel = Submodel(
        "Fertility",
        reads=("breeding",),
        rules={
            "breeding.end": "`fertility ∝ u^(3 m) (1 − u)^(3 (1 − m))`, where u is the elapsed share of "
            "the time from maturity to the end of fertility, and m is u at the prime (Brass 1975; Gage "
            "2001).",
            "breeding.season": "The season multiplies it by `exp(κ (cos 2π(t − season) − 1))`, where t is "
            "the elapsed share of the year and `κ = 1/(2π width)²` (von Mises).",
        },
        changes=("Biology.fertility",),
    )
    asked_for = staticmethod(lambda table: table.species.breeding is not None)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Set the fertility of one species for this tick."""
        way, year = table.species.breeding, world.environment.year
        if way is None:
            return
        b = table[Biology]
        world.split(
            ripen,
            table.high,
            table.alive,
            b.age,
            columns(table, way),
            Breeding in table,
            0.0 if year is None else year.share(world.time),
            year is not None,
            b.fertility,
        )


def columns(table: Table, way: Season) -> Fertility:
    """Return fertility by age and season: columns, or the species' values as arrays of length 1."""
    if Breeding in table:
        b = table[Breeding]
        prime = b.prime
        if way.prime is None and "breeding.prime" not in (table.species.traits or ()):
            prime = np.where(b.end < NEVER, b.maturity + (b.end - b.maturity) / 3, b.maturity)
        return Fertility(b.peak, b.maturity, prime, b.end, b.season, b.width)
    values = (
        table.species.fertility,
        way.maturity,
        way.age_of_prime(),
        NEVER if way.end is None else way.end,
        way.season or 0.0,
        0.0 if way.season is None else way.width,
    )
    return Fertility(*(np.array([v], np.float32) for v in values))


@njit
def ripen(
    first: int,
    last: int,
    alive: np.ndarray,
    age: np.ndarray,
    curve: Fertility,
    own: bool,
    share: float,
    seasonal: bool,
    fertility: np.ndarray,
) -> None:
    """Set the fertility of living organisms when `share` of the year has passed."""
    peak, maturity, prime, end, season, width = curve
    for row in range(first, last):
        if alive[row]:
            i = row if own else 0
            value = np.float64(peak[i]) * by_age(
                np.float64(age[row]), np.float64(maturity[i]), np.float64(prime[i]), np.float64(end[i])
            )
            if seasonal and width[i] > 0:
                kappa = 1.0 / (2.0 * math.pi * np.float64(width[i])) ** 2
                value *= math.exp(kappa * (math.cos(2.0 * math.pi * (share - season[i])) - 1.0))
            fertility[row] = value


@njit
def by_age(age, maturity, prime, end):
    """Return fertility at a given age [s] as a share of its peak."""
    if age < maturity or age >= end:
        return 0.0
    if end >= NEVER:
        return min((age - maturity) / (prime - maturity), 1.0) if prime > maturity else 1.0
    u = (age - maturity) / (end - maturity)
    m = min(max((prime - maturity) / (end - maturity), EDGE), 1.0 - EDGE)
    return (u / m) ** (3.0 * m) * ((1.0 - u) / (1.0 - m)) ** (3.0 * (1.0 - m))
