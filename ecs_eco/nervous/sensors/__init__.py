"""Sensors, one kind per file. Each fills its channels, which are columns of the observations f32[n,
channels].

A new kind of sensor needs a file here, a model in `ecs_eco.config.models.sensors`, and a line in `senses_of`.
Neighbors, light and smells belong in `ecs_eco.space`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ecs_eco.inputs.code import handed_over
from ecs_eco.nervous.sensors.alignment import feel_alignment
from ecs_eco.nervous.sensors.approach import feel_approach
from ecs_eco.nervous.sensors.gradient import smell_gradient
from ecs_eco.nervous.sensors.nearest import see_nearest
from ecs_eco.nervous.sensors.own import own
from ecs_eco.nervous.sensors.property import feel_property
from ecs_eco.nervous.sensors.rays import cast_rays
from ecs_eco.nervous.sensors.sense import Sense
from ecs_eco.nervous.sensors.smell import smell
from ecs_eco.nervous.sensors.surroundings import ambient
from ecs_eco.nervous.sensors.touch import touch

if TYPE_CHECKING:
    from ecs_eco.config.models.species import Species


def senses_of(
    species: Species,
    dims: int,
    substances: list[str],
    find: Callable[[Any], Any] = handed_over,
    bearers: Callable[[str], list[str]] = lambda _: [],
) -> list[tuple[Sense, int]]:
    """Return (sense, number of channels) for each sensor of a species' configuration; `bearers(property)`
    returns the kinds of bodies that have a property."""
    made = [
        Sense(find(s.function), divisible=False)
        if s.kind == "custom"
        else _property_of(s, bearers(s.property), substances, i)
        if s.kind == "property"
        else _sense_of(s, substances, i)
        for i, s in enumerate(species.sensors)
    ]
    return [(sense, len(s.channels(dims))) for sense, s in zip(made, species.sensors, strict=True)]


def _sense_of(s: Any, substances: list[str], number: int) -> Sense:
    if s.kind == "own":
        return own(s.property, s.scale, substances, number, s.at)
    if s.kind == "nearest":
        return see_nearest(s.target, s.range, s.fov, s.occlusion, number, s.sight, s.blind, s.kin, s.at)
    if s.kind == "rays":
        return cast_rays(
            s.targets, s.count, s.fov, s.range, s.report, number, s.at, s.angle, s.sight, s.blind
        )
    if s.kind == "smell":
        return smell(s.field, s.at, s.half_saturation, number)
    if s.kind == "touch":
        names = None if s.target == "any" else ([] if s.target == "wall" else [s.target])
        return touch(names, s.target in ("any", "wall"), s.at)
    if s.kind == "gradient":
        return smell_gradient(s.field, s.span, s.scale, number)
    if s.kind == "approach":
        return feel_approach(s.target, s.range, s.scale, number)
    if s.kind == "alignment":
        return feel_alignment(s.target, s.range, number)
    return ambient(s.kind, s.zero, s.scale, s.at, number, getattr(s, "dark", None))


def _property_of(s: Any, bearers: list[str], substances: list[str], number: int) -> Sense:
    return feel_property(
        s.property,
        s.kinds() or bearers,
        s.range,
        s.decay,
        s.report,
        s.zero,
        s.scale,
        s.at,
        substances,
        number,
        s.kin,
    )
