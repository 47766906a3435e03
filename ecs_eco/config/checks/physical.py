"""Checks of how the pressure in bodies changes."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.checks.matter import Key
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.surroundings import ObjectType
from ecs_eco.engine.errors import Problem


def check_physical(key: Key, kind: Species | ObjectType) -> Iterator[Problem]:
    """Problems of compressible bodies without a pressure."""
    if kind.body.compressible and "pressure" not in kind.properties:
        yield Problem(
            (*key, "properties", "pressure"),
            "is missing, and body.compressible changes it",
            allowed="the pressure at the start [Pa], or compressible = false",
        )
