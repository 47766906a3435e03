"""Checks of what people do with land and sea all the time."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.checks.interventions import check_region
from ecs_eco.config.models.land_use import Harvest
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import named
from ecs_eco.engine.errors import Problem


def check_land_use(config: WorldConfig) -> Iterator[Problem]:
    """All problems of harvests and plantings."""
    kinds = [*config.species, *config.objects]
    for i, use in enumerate(config.land_use):
        key = ("land_use", i)
        yield from named((*key, "species"), "species or object type", use.species, kinds)
        if use.region is not None:
            yield from check_region((*key, "region"), use.region, config)
        if use.until is not None and use.until < use.at:
            yield Problem((*key, "until"), "before at", use.until, f"at least {use.at}")
        if use.season is not None and use.period is None:
            yield Problem(
                (*key, "period"), "is missing: a season is a part of it", allowed="the length of a year [s]"
            )
        if use.period is not None and use.period < config.dt:
            yield Problem(
                (*key, "period"), "shorter than a tick", use.period, f"at least dt, {config.dt:g} s"
            )
        if use.season is not None and use.season[0] == use.season[1]:
            yield Problem(
                (*key, "season"), "ends when it begins", use.season, "two different shares of a year"
            )
        if isinstance(use, Harvest) and use.most is not None and (use.least or 0.0) > use.most:
            yield Problem(
                (*key, "most"), "less than least: nothing is taken", use.most, f"at least {use.least:g} m"
            )
