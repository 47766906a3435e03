"""Checks of the course of a life, and of the year that it follows."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.checks.matter import Key
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import Problem


def check_year(config: WorldConfig) -> Iterator[Problem]:
    """The problem of a year that is given twice."""
    if config.year is not None and config.sun is not None and config.sun.year is not None:
        yield Problem(
            ("sun", "year"),
            "given together with the world's own year",
            config.sun.year,
            "one of year.length and sun.year",
        )


def check_life(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    """All problems of the course of a species' life."""
    if species.age is not None and species.age[0] > species.age[1]:
        yield Problem(
            (*key, "age"),
            "the least is more than the most",
            species.age,
            f"[{species.age[1]:g}, {species.age[0]:g}]",
        )
