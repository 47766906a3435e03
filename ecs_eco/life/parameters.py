"""Parameters of custom systems and sensors in a live world."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from ecs_eco.config import WorldConfig
from ecs_eco.engine.errors import Problem
from ecs_eco.inputs.section import Use
from ecs_eco.nervous.sensors.sense import Sense

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld


def kept_elsewhere(world: SpatialWorld, new: WorldConfig) -> list[Problem]:
    """Return a problem for each changed parameter whose system has no attribute of the same name."""
    fault = "cannot change in a live world, because {} has no attribute {}"
    return [
        Problem(
            ("systems", i, name),
            fault.format(type(system).__name__, name),
            value,
            f"a system that reads self.{name} in each tick",
        )
        for i, system, name, value in _changed(world, new)
        if not hasattr(system, name)
    ]


def set_parameters(world: SpatialWorld, new: WorldConfig) -> None:
    """Give custom systems and sensors their new parameters."""
    for _, system, name, value in _changed(world, new):
        setattr(system, name, value)
    for kind, species in new.species.items():
        nerves = world.tables[kind].species.nerves
        for i, sensor in enumerate(species.sensors):
            now, before = getattr(sensor, "function", None), world.config.species[kind].sensors[i]
            if nerves is not None and isinstance(now, Use) and now != before.function:
                nerves.senses[i] = (Sense(new.function(now), divisible=False), nerves.senses[i][1])


def _changed(world: SpatialWorld, new: WorldConfig) -> Iterator[tuple[int, Any, str, Any]]:
    """Yield each changed parameter as (position of its system, the system, name, new value)."""
    for i, (before, now) in enumerate(zip(world.config.systems, new.systems, strict=False)):
        old = before.parameters if isinstance(before, Use) else {}
        for name, value in now.parameters.items() if isinstance(now, Use) else ():
            if i < len(world.own_systems) and (name not in old or old[name] != value):
                yield i, world.own_systems[i], name, value
