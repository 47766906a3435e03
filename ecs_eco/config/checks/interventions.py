"""Checks of interventions and land use: whether everything they name exists, is in the world and can change."""

import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from ecs_eco.config.models.interventions import (
    REGION,
    Add,
    Cull,
    Dose,
    Fence,
    Harvest,
    Intervention,
    Road,
    Set,
    Switch,
)
from ecs_eco.config.models.reproduction import Spread
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.mutable_keys import refused
from ecs_eco.config.rules import Key, extent, inside, named, written_at
from ecs_eco.engine.errors import ConfigError, Problem, listed

Kind = TypeVar("Kind", bound=Intervention)
Changed = Callable[[WorldConfig, Mapping[str, Any], Path], WorldConfig]


def check_interventions(config: WorldConfig, folder: Path, changed: Changed) -> Iterator[Problem]:
    """Yield the problems with interventions; `changed(config, values, folder)` returns a checked world."""
    for i, intervention in enumerate(config.interventions):
        key = ("interventions", i)
        yield from _check_time(config, key, intervention)
        if isinstance(intervention, Cull | Add):
            known = [*config.species, *config.objects]
            yield from named((*key, "species"), "species or object type", intervention.species, known)
        if isinstance(intervention, Cull):
            yield from _check_cull(config, key, intervention)
        if isinstance(intervention, Cull | Add | Dose | Fence) and intervention.region is not None:
            yield from check_region((*key, "region"), intervention.region, config)
        if isinstance(intervention, Add):
            yield from _check_add(config, key, intervention)
        elif isinstance(intervention, Dose):
            yield from _check_dose(config, key, intervention)
        elif isinstance(intervention, Switch):
            yield from _check_switch(config, key, intervention)
    yield from _check_standing(config, Fence, [])
    roads = [] if config.terrain is None else config.terrain.roads
    yield from _check_standing(config, Road, [(road.line, None) for road in roads])
    yield from _check_sets(config, folder, changed)


def _check_time(config: WorldConfig, key: Key, intervention: Intervention) -> Iterator[Problem]:
    at, until = intervention.at, intervention.until
    if at >= config.ticks:
        allowed = f"0 to {config.ticks - 1}, or larger `ticks` in the world"
        yield Problem((*key, "at"), f"never happens: a run has {config.ticks} ticks", at, allowed)
    if until is not None and intervention.every is None:
        yield Problem((*key, "until"), "given without `every`", until, "both or neither")
    elif until is not None and until < at:
        yield Problem((*key, "until"), "earlier than `at`", until, f"at least {at}")


def _check_cull(config: WorldConfig, key: Key, cull: Cull) -> Iterator[Problem]:
    if (cull.share, cull.count, cull.uids).count(None) != 2:
        allowed = "share = 0.5, count = 20, or uids = [7]"
        yield Problem((*key, "share"), "give exactly one of share, count and uids", allowed=allowed)
    if cull.which in ("richest", "poorest") and cull.species in config.objects:
        allowed = "random, oldest, youngest, largest, smallest"
        yield Problem((*key, "which"), "objects have no energy", cull.which, allowed)


def check_region(key: Key, region: list[float], config: WorldConfig) -> Iterator[Problem]:
    """Yield problems with a region that extends beyond the world."""
    size = config.space.size[:2]
    allowed = f"{REGION}, within {extent(size)}"
    if len(region) == 4:
        for low, high, length, axis in zip(region[:2], region[2:], size, "xy", strict=True):
            if low < 0 or high > length:
                yield Problem(key, f"outside the world along {axis}", region, allowed)
            elif low >= high:
                fault = f"empty along {axis}: {axis}0 is not less than {axis}1"
                yield Problem(key, fault, region, REGION)
        return
    most = min(size) / 2 if config.space.edges == "torus" else math.hypot(*size)
    if not all(0 <= x <= length for x, length in zip(region, size, strict=False)):
        yield Problem(key, "its center is outside the world", region, allowed)
    if not 0 < region[2] <= most:
        yield Problem(key, f"its radius is {region[2]:g} m", region, f"more than 0, at most {most:g} m")


def _check_add(config: WorldConfig, key: Key, add: Add) -> Iterator[Problem]:
    kind, place, at = config.species.get(add.species), add.at_place, (*key, "at_place")
    if kind is not None and kind.max_count is not None and add.count > kind.max_count:
        fault = f"more than max_count of {add.species}"
        yield Problem((*key, "count"), fault, add.count, f"at most {kind.max_count}")
    if place is None:
        return
    if add.region is not None:
        yield Problem(at, "given together with region", place, "only one of them")
    outside = list(inside(at, place, config.space.size))
    yield from outside
    for group in () if outside or config.terrain is None else ("rocks", "lakes"):
        for i, mark in enumerate(getattr(config.terrain, group)):
            if math.dist(mark.at, place[:2]) < mark.radius:
                yield Problem(at, f"within terrain.{group}.{i}", place, "a position on open ground")
    if kind is not None and isinstance(kind.reproduction, Spread) and add.count > 1:
        allowed = "count = 1, or a region instead of at_place"
        yield Problem((*key, "count"), f"a site holds only one {add.species}", add.count, allowed)


def _check_dose(config: WorldConfig, key: Key, dose: Dose) -> Iterator[Problem]:
    at = (*key, "substance")
    if (dose.field is None) == (dose.species is None):
        allowed = 'field = "soil", or species = "deer" with a substance'
        yield Problem((*key, "field"), "give either field or species", allowed=allowed)
    elif dose.field is not None:
        yield from named((*key, "field"), "field", dose.field, config.fields)
        if dose.substance is not None:
            yield Problem(
                at, "given together with field", dose.substance, "no substance: a field defines its own"
            )
    else:
        holders = [name for name, kind in config.objects.items() if kind.substances]
        holders += [name for name, kind in config.species.items() if kind.substances]
        word = "species or object type with substances"
        yield from named((*key, "species"), word, str(dose.species), holders)
        if dose.substance is None:
            yield Problem(at, "is missing", allowed=listed(config.substances))
        else:
            yield from named(at, "substance", dose.substance, config.substances)
    if dose.amount == 0:
        yield Problem((*key, "amount"), "not a dose", 0.0, "a positive or negative number")


def _check_switch(config: WorldConfig, key: Key, switch: Switch) -> Iterator[Problem]:
    if switch.reproduction is None and switch.learning is None:
        allowed = "true or false for one of them, or both"
        yield Problem((*key, "reproduction"), "neither reproduction nor learning is given", allowed=allowed)
    if switch.species is None:
        return
    yield from named((*key, "species"), "species", switch.species, config.species)
    if switch.learning and switch.species in config.species and not learns(config.species[switch.species]):
        allowed = "a species with a policy network and happiness"
        yield Problem((*key, "learning"), f"{switch.species} cannot learn", True, allowed)


def learns(species: Species) -> bool:
    """Return whether a species can learn."""
    return species.policy.thinks and species.happiness is not None


def _check_standing(
    config: WorldConfig, kind: type[Fence | Road], there: list[tuple[Any, Any]]
) -> Iterator[Problem]:
    """Yield problems with fences or roads, in chronological order; only those in `there` can be removed."""
    missing, lines, gone, allowed = {
        Fence: (
            "neither line nor region is given",
            "corners [[x, y], …], or a region",
            "no such fence exists at that time",
            "the line or region of an existing fence, or neither for all fences",
        ),
        Road: (
            "is missing",
            "corners [[x, y], …]",
            "no such road exists at that time",
            "the line of an existing road, or none for all roads",
        ),
    }[kind]
    for key, it in _in_time(config, kind):
        shape = line, region = it.line, getattr(it, "region", None)
        if line is not None and region is not None:
            yield Problem((*key, "region"), "given together with line", region, "only one of them")
        elif shape == (None, None) and not it.remove:
            yield Problem((*key, "line"), missing, allowed=lines)
        yield from check_line((*key, "line"), line or [], config)
        if not it.remove:
            there.append(shape)
        elif shape == (None, None):
            there.clear()
        elif shape in there:
            there.remove(shape)
        else:
            yield Problem((*key, "remove"), gone, True, allowed)


def _in_time(config: WorldConfig, kind: type[Kind]) -> list[tuple[Key, Kind]]:
    """Return the interventions of a kind with their keys, in chronological order."""
    found = [
        (("interventions", i), one) for i, one in enumerate(config.interventions) if isinstance(one, kind)
    ]
    return sorted(found, key=lambda pair: pair[1].at)


def check_line(key: Key, line: list[list[float]], config: WorldConfig) -> Iterator[Problem]:
    """Yield problems with corners [x, y] [m] that are outside the world."""
    size = config.space.size[:2]
    for corner in line:
        if not all(0 <= x <= s for x, s in zip(corner, size, strict=False)):
            yield Problem(key, "a corner outside the world", corner, extent(size))


def _check_sets(config: WorldConfig, folder: Path, changed: Changed) -> Iterator[Problem]:
    """Yield problems with values to be set, in chronological order; each change must leave a valid world."""
    now = config
    for place, change in _in_time(config, Set):
        key = (*place, "set")
        if any(name.partition(".")[0] == "interventions" for name in change.set):
            fault = "interventions cannot change other interventions"
            yield Problem(key, fault, allowed="keys outside interventions")
            continue
        try:
            new = changed(now, change.set, folder)
            problems = refused(now, new)
        except ConfigError as error:
            new, problems = now, error.problems
        for p in problems:
            written = next((k for k in change.set if p.path == k or p.path.endswith(k)), None)
            yield written_at(p, key, written)
        now = now if problems else new


def check_land_use(config: WorldConfig) -> Iterator[Problem]:
    """Yield all problems with harvests and plantings."""
    kinds = [*config.species, *config.objects]
    for i, use in enumerate(config.land_use):
        key = ("land_use", i)
        yield from named((*key, "species"), "species or object type", use.species, kinds)
        if use.region is not None:
            yield from check_region((*key, "region"), use.region, config)
        if use.until is not None and use.until < use.at:
            yield Problem((*key, "until"), "earlier than `at`", use.until, f"at least {use.at}")
        if use.season is not None and use.period is None:
            yield Problem(
                (*key, "period"), "is missing, but season needs it", allowed="the length of a year [s]"
            )
        if use.period is not None and use.period < config.dt:
            yield Problem(
                (*key, "period"), "shorter than a tick", use.period, f"at least dt, {config.dt:g} s"
            )
        if use.season is not None and use.season[0] == use.season[1]:
            yield Problem(
                (*key, "season"), "start and end are equal", use.season, "two different fractions of a year"
            )
        if isinstance(use, Harvest) and use.most is not None and (use.least or 0.0) > use.most:
            yield Problem(
                (*key, "most"),
                "less than `least`, so nothing is removed",
                use.most,
                f"at least {use.least:g} m",
            )
