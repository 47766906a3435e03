"""Checks of how objects move."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.checks.matter import Key
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
