"""Checks that objects and organisms share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ecs_eco.config.models.surroundings import PROPERTIES
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import Problem, listed, nearest

Key = tuple[str | int, ...]


def unknown(key: Key, kind: str, value: str, known: Iterable[str]) -> Problem:
    """The problem of an unknown name."""
    known = list(known)
    return Problem(key, f"no {kind} of this name", value, listed(known, 30), nearest(value, known))


def check_matter(
    config: WorldConfig, key: Key, properties: Iterable[str], substances: Iterable[str]
) -> Iterator[Problem]:
    """Problems of undeclared properties and substances."""
    for name in properties:
        if name not in PROPERTIES:
            yield unknown((*key, "properties", name), "property", name, PROPERTIES)
    for name in substances:
        if name not in config.substances:
            yield unknown((*key, "substances", name), "substance", name, config.substances)


def check_size(config: WorldConfig, key: Key, radius: float) -> Iterator[Problem]:
    """Problems of a body that does not fit into the world."""
    most = min(config.space.size) / 2
    if radius > most:
        yield Problem((*key, "body", "radius"), "the body does not fit into the world", radius,
                      f"at most {most:g} m")
