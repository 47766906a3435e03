"""Checks of fields of substances."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import Problem, unknown


def check_field_of_substance(config: WorldConfig, name: str) -> Iterator[Problem]:
    """All problems of what a field holds."""
    field, key = config.fields[name], ("fields", name)
    if field.substance is not None and field.substance not in config.substances:
        yield unknown((*key, "substance"), "substance", field.substance, config.substances)
    for part in ("depth", "initial", "renewal", "only"):
        if field.substance is None and getattr(field, part) is not None:
            yield Problem(
                (*key, part),
                "given without a substance",
                getattr(field, part),
                "a substance that the field holds, or none of these",
            )
    if field.depth is not None and config.dims == 3:
        yield Problem((*key, "depth"), "a volume has a depth of its own", field.depth, "no depth")
    ground = config.terrain
    if field.only == "lakes" and (ground is None or not (ground.lakes or ground.raster)):
        yield Problem((*key, "only"), "there are no lakes", field.only, "terrain.lakes, or no `only`")
