"""Checks of how substances move: decay, newborn, and their fields."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.checks.matter import Key
from ecs_eco.config.features.substances import check_held
from ecs_eco.config.models.reproduction import Spread
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.surroundings import ObjectType
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import Problem, unknown

Kind = Species | ObjectType


def check_chemistry(config: WorldConfig, key: Key, kind: Kind) -> Iterator[Problem]:
    """All problems of what a species or object type does with its substances."""
    for part in ("decomposition", "born_with"):
        yield from check_held(kind, config, key, part)
    if isinstance(kind, Species):
        yield from _check_newborn(config, key, kind)


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


def _check_newborn(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    at, way = (*key, "born_with"), species.reproduction
    if species.born_with == "mother" and (way is None or isinstance(way, Spread)):
        yield Problem(at, "it has no mother", "mother", "declared or soil, or another reproduction")
    if species.born_with != "soil":
        return
    if not isinstance(way, Spread):
        yield Problem(at, "it has no seeds", "soil", 'declared or mother, or reproduction.kind = "spread"')
    held = {field.substance for field in config.fields.values()}
    for name, concentration in species.substances.items():
        if concentration > 0 and name not in held:
            yield Problem(
                (*key, "substances", name),
                "no field holds it, and newborn take it from the soil",
                concentration,
                "0, or a field with this substance",
            )
