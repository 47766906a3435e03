"""Checks of the water, and of features that need a volume of water."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import named
from ecs_eco.engine.errors import Problem

MOST_LAYERS = 100_000


def check_water(config: WorldConfig) -> Iterator[Problem]:
    """All problems of the water, of sinking, and of swimming."""
    yield from _check_volume(config)
    water, size = config.water, config.space.size
    if water is None:
        return
    if config.dims == 2:
        yield Problem(
            ("water",), "there is no depth in a plane", allowed="a space of three sizes, or no water"
        )
        return
    for name in water.shading:
        yield from named(("water", "shading", name), "species", name, config.species)
    if water.layer > size[2] or size[2] / water.layer > MOST_LAYERS:
        allowed = f"at most {size[2]:g} m, and at least {size[2] / MOST_LAYERS:g}"
        yield Problem(("water", "layer"), "no layer of this water", water.layer, allowed)
    for i, current in enumerate(water.current):
        for axis, speed in enumerate(current.velocity):
            if abs(speed) * config.dt > (most := size[axis] / 2):
                fault = "further than half of the world in one tick"
                yield Problem(
                    ("water", "current", i, "velocity"), fault, speed, f"at most {most / config.dt:g} m/s"
                )
    if water.current and water.current_function is not None:
        fault = "given together with a current by depth"
        yield Problem(("water", "current_function"), fault, allowed="one of current and current_function")


def _check_volume(config: WorldConfig) -> Iterator[Problem]:
    bodies = [("species", n, s.body) for n, s in config.species.items()] + [
        ("objects", n, o.body) for n, o in config.objects.items()
    ]
    for section, name, body in bodies:
        if body.sinking and config.dims == 2:
            yield Problem(
                (section, name, "body", "sinking"),
                "no up and down in a plane",
                body.sinking,
                "0, or a space of three sizes",
            )
    for name, species in config.species.items():
        way = species.locomotion
        if way is not None and way.pitch and way.climb:
            allowed = "one of climb and pitch"
            yield Problem(
                ("species", name, "locomotion", "pitch"), "given together with climb", way.pitch, allowed
            )
