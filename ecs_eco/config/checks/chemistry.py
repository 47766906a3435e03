"""Checks of how substances move: reactions, exchange, decay, newborn, and their fields."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.checks.matter import Key
from ecs_eco.config.features.substances import substances_of
from ecs_eco.config.models.matter import Release
from ecs_eco.config.models.reproduction import Spread
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.surroundings import ObjectType
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import Problem, unknown

Kind = Species | ObjectType


def check_chemistry(config: WorldConfig, key: Key, kind: Kind) -> Iterator[Problem]:
    """All problems of what a species or object type does with its substances."""
    moves = {
        "reactions": kind.reactions,
        "exchange": kind.exchange,
        "decomposition": getattr(kind, "decomposition", None),
        "born_with": getattr(kind, "born_with", "declared") != "declared",
    }
    used = next((name for name, ways in moves.items() if ways), None)
    if used is not None and not substances_of(config, key[1]):
        yield Problem(
            (*key, "substances"),
            f"is missing, and {used} changes them",
            allowed="concentrations at the start [mol/L], 0 for those that it begins without",
        )
    yield from _check_reactions(config, key, kind)
    yield from _check_exchange(config, key, kind)
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


def _check_reactions(config: WorldConfig, key: Key, kind: Kind) -> Iterator[Problem]:
    for i, reaction in enumerate(kind.reactions):
        at = (*key, "reactions", i)
        for part in ("from", "to", "half"):
            for name in getattr(reaction, part):
                if name not in config.substances:
                    yield unknown((*at, part, name), "substance", name, config.substances)
        if reaction.energy and isinstance(kind, ObjectType):
            yield Problem((*at, "energy"), "objects hold no energy", reaction.energy, "0")
        yield from _check_action((*at, "action"), kind, reaction.action)


def _check_exchange(config: WorldConfig, key: Key, kind: Kind) -> Iterator[Problem]:
    for i, way in enumerate(kind.exchange):
        at = (*key, "exchange", i)
        holding = {name: f.substance for name, f in config.fields.items() if f.substance is not None}
        if isinstance(way, Release) and way.substance not in config.substances:
            yield unknown((*at, "substance"), "substance", way.substance, config.substances)
        if way.field is not None and way.field not in holding:
            yield unknown((*at, "field"), "field of a substance", way.field, holding)
        elif isinstance(way, Release) and way.field is not None and holding[way.field] != way.substance:
            yield Problem(
                (*at, "field"), f"it holds {holding[way.field]}", way.field, f"a field of {way.substance}"
            )
        yield from _check_action((*at, "action"), kind, getattr(way, "action", None))


def _check_action(at: Key, kind: Kind, action: str | None) -> Iterator[Problem]:
    if action is None:
        return
    if isinstance(kind, ObjectType):
        yield Problem(at, "objects do not act", action, "no action")
    elif action not in kind.action_rows():
        yield unknown(at, "action of the species", action, kind.action_rows())
    elif kind.action_list()[kind.action_rows()[action]][0] in kind.ranges():
        yield Problem(at, "is continuous", action, "an action that is done or not")


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
