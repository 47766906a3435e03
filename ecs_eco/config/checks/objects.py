"""Checks of how objects move, and of what species do with them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ecs_eco.config.checks.matter import Key, unknown
from ecs_eco.config.models.surroundings import ObjectType
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import Problem


def check_motion(config: WorldConfig, key: Key, kind: ObjectType) -> Iterator[Problem]:
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
    places = {("velocity",): motion.velocity} | {("path", i): p for i, p in enumerate(motion.path or ())}
    for part, numbers in places.items():
        if numbers is not None and len(numbers) != len(size):
            yield Problem((*at, *part), "wrong number of coordinates", numbers, f"{len(size)} numbers")
        elif part != ("velocity",) and not all(0 <= x < s for x, s in zip(numbers or (), size, strict=True)):
            yield Problem(
                (*at, *part), "outside of the world", numbers, " and ".join(f"0 to {s:g} m" for s in size)
            )
    fastest, most = max(map(abs, motion.velocity or [motion.speed or 0.0])), min(size) / 2 / config.dt
    if fastest > most:
        yield Problem(at, "further than half of the world in one tick", fastest, f"at most {most:g} m/s")


def check_handling(config: WorldConfig, name: str, widest: float) -> Iterator[Problem]:
    """All problems of what a species carries and builds; searches may not be wider than `widest` [m]."""
    species, key = config.species[name], ("species", name)
    sections: dict[str, list[Any]] = {"carries": species.carries, "builds": species.builds}
    for section, ways in sections.items():
        named: set[str] = set()
        for i, way in enumerate(ways):
            at = (*key, section, i)
            if way.object not in config.objects:
                yield unknown((*at, "object"), "object type", way.object, config.objects)
            elif way.object in named:
                yield Problem((*at, "object"), "named twice", way.object, "one entry for each object type")
            elif section == "carries" and config.objects[way.object].body.solid:
                yield Problem(
                    (*at, "object"),
                    "is solid: nothing else can be where it is",
                    way.object,
                    f"objects.{way.object}.body.solid = false",
                )
            named.add(way.object)
            distance = "reach" if section == "carries" else "spacing"
            if getattr(way, distance) > widest:
                yield Problem(
                    (*at, distance),
                    "larger than the world allows to look",
                    getattr(way, distance),
                    f"at most {widest:g} m",
                )
        group = {"carries": "carry", "builds": "build"}[section]
        if group in species.actions and not ways:
            yield Problem(
                (*key, "actions", group),
                f"it {section} nothing",
                species.actions[group],
                f'{section} = [{{ object = "stick", … }}], or no such group',
            )
