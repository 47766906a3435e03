"""Checks of one type of inanimate objects: where they are at the start, and what they are made of."""

import math
from collections.abc import Iterator

from ecs_eco.config.checks.body import check_matter, check_size, longest
from ecs_eco.config.features.feature import of_each
from ecs_eco.config.features.heat import check_heat
from ecs_eco.config.models.surroundings import ObjectType
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import Key, at_most, extent, inside
from ecs_eco.engine.errors import Problem


def check_object(config: WorldConfig, name: str, kind: ObjectType) -> Iterator[Problem]:
    """All problems of an object type."""
    key, placed = ("objects", name), [*kind.at, *kind.between]
    if kind.count and placed:
        fault = "given together with at" if kind.at else "given together with between"
        yield Problem((*key, "count"), fault, kind.count, "one of count and at")
    made = (name in (s.remains, *of_each(s, "makes")) for s in config.species.values())
    if not kind.count and not placed and not any(made):
        allowed = "at least 1, or a list at, or a species that leaves it as remains or builds it"
        yield Problem((*key, "count"), "none of these would ever exist", kind.count, allowed)
    for i, at in enumerate(kind.at):
        yield from inside((*key, "at", i), at, config.space.size)
    if len(kind.heading) not in (0, 1, len(kind.at)):
        yield Problem(
            (*key, "heading"),
            f"{len(kind.heading)} headings for {len(kind.at)} places in at",
            kind.heading,
            f"{len(kind.at)} numbers [rad], or one for all",
        )
    elif kind.heading and not kind.at:
        yield Problem((*key, "heading"), "given without at", kind.heading, "places in at that have it")
    if kind.renewal and not kind.count:
        yield Problem(
            (*key, "renewal"),
            "there is no count for it to come back to",
            kind.renewal,
            "count of at least 1, or no renewal",
        )
    yield from _check_ways(config, key, kind)
    yield from check_matter(config, key, kind)
    yield from check_size(config, key, kind.body)
    yield from check_heat(kind, key)
    yield from _check_motion(config, key, kind)
    yield from of_each(kind, "problems", config, key)


def _check_ways(config: WorldConfig, key: Key, kind: ObjectType) -> Iterator[Problem]:
    """Problems of objects that reach from one place to another."""
    if kind.between and kind.body.shape == "sphere":
        yield Problem(
            (*key, "between"),
            "a sphere has no length that could reach from place to place",
            allowed='body.shape = "capsule" or "box", or places in at',
        )
        return
    size, most = config.space.size[:2], longest(config)
    least = 0.0 if kind.body.shape == "box" else 2 * kind.body.radius
    for i, way in enumerate(kind.between):
        at = (*key, "between", i)
        if not all(0 <= x <= side for x, side in zip(way, size * 2, strict=True)):
            yield Problem(at, "outside of the world", way, extent(size))
        elif not least < (length := math.dist(way[:2], way[2:])) <= most:
            yield Problem(
                at, f"{length:g} m from end to end", way, f"more than {least:g} m, at most {most:g} m"
            )


def _check_motion(config: WorldConfig, key: Key, kind: ObjectType) -> Iterator[Problem]:
    """All problems of how objects of a type move."""
    if kind.pushed and not kind.body.solid:
        yield Problem((*key, "pushed"), "nothing pushes what is not solid", True, "body.solid = true")
    motion, size, at = kind.motion, config.space.size, (*key, "motion")
    if motion is None:
        return
    if (motion.velocity is None) == (motion.path is None):
        yield Problem(
            (*at, "velocity"),
            "give either a velocity or a path",
            allowed="velocity = [1.0, 0.0], or a path and a speed",
        )
    if motion.path is not None and motion.speed is None:
        yield Problem((*at, "speed"), "is missing: it goes along a path", allowed="a speed [m/s]")
    if motion.path is None and motion.speed is not None:
        yield Problem((*at, "speed"), "given without a path", motion.speed, "a path, or a velocity alone")
    if motion.velocity is not None and len(motion.velocity) != len(size):
        yield Problem(
            (*at, "velocity"), "wrong number of coordinates", motion.velocity, f"{len(size)} numbers"
        )
    for i, place in enumerate(motion.path or ()):
        yield from inside((*at, "path", i), place, size)
    fastest = max(map(abs, motion.velocity or [motion.speed or 0.0]))
    most = min(size) / 2 / config.dt
    yield from at_most(at, "further than half of the world in one tick", fastest, most, " m/s")
