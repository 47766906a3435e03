"""Checks that objects and organisms share."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ecs_eco.config.models.body import Body
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.surroundings import PROPERTIES, ObjectType
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import Key, at_most, named
from ecs_eco.engine.errors import Problem


def check_matter(config: WorldConfig, key: Key, kind: Species | ObjectType) -> Iterator[Problem]:
    """Problems of undeclared properties and substances, and of compressible bodies without a pressure."""
    for name in kind.properties:
        yield from named((*key, "properties", name), "property", name, PROPERTIES)
    for name in kind.substances:
        yield from named((*key, "substances", name), "substance", name, config.substances)
    if kind.body.compressible and "pressure" not in kind.properties:
        yield Problem(
            (*key, "properties", "pressure"),
            "is missing, and body.compressible changes it",
            allowed="the pressure at the start [Pa], or compressible = false",
        )


def check_size(config: WorldConfig, key: Key, body: Body) -> Iterator[Problem]:
    """Problems of a body that does not fit into the world."""
    size, at = config.space.size, (*key, "body")
    if body.shape == "sphere":
        fault = "the body does not fit into the world"
        yield from at_most((*at, "radius"), fault, body.radius, min(size) / 2)
        return
    name, most = "length" if body.shape == "capsule" else "size", longest(config)
    if max(body.extents[:2]) > most:
        yield Problem((*at, name), "the body does not fit into the world", allowed=f"at most {most:g} m")
    if len(size) == 3:
        part = (*at, "radius" if body.shape == "capsule" else name)
        yield from at_most(part, "higher than the world is deep", body.extents[2], size[2])


def longest(config: WorldConfig) -> float:
    """How long a capsule or a box may be [m]: the shorter side of a torus, or the diagonal between walls."""
    sides = config.space.size[:2]
    return min(sides) if config.space.edges == "torus" else math.hypot(*sides)
