"""Checks of how temperature and pressure of bodies change."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.checks.matter import Key
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.surroundings import ObjectType
from ecs_eco.engine.errors import Problem


def check_physical(key: Key, kind: Species | ObjectType) -> Iterator[Problem]:
    """Problems of bodies that exchange heat and have no temperature, or regulate it without any power;
    and of compressible ones without a pressure."""
    if kind.body.compressible and "pressure" not in kind.properties:
        yield Problem(
            (*key, "properties", "pressure"),
            "is missing, and body.compressible changes it",
            allowed="the pressure at the start [Pa], or compressible = false",
        )
    if kind.heat is None:
        return
    if "temperature" not in kind.properties:
        yield Problem(
            (*key, "properties", "temperature"),
            "is missing, and heat changes it",
            allowed="the temperature at the start [K], or no heat",
        )
    elif kind.properties["temperature"] < 0:
        yield Problem(
            (*key, "properties", "temperature"),
            "below absolute zero",
            kind.properties["temperature"],
            "at least 0 K",
        )
    regulation = getattr(kind.heat, "regulate", None)
    if regulation is not None and regulation.warming == regulation.cooling == 0:
        yield Problem(
            (*key, "heat", "regulate", "warming"),
            "is 0, and cooling too",
            0.0,
            "a power [W] of warming, of cooling or of both; or no regulate",
        )
