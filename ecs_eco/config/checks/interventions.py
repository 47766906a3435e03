"""Checks of interventions: all that they name exists, lies in the world, and may change in a living world."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ecs_eco.config.checks.matter import Key
from ecs_eco.config.models.interventions import REGION, Add, Cull, Dose, Fence, Road, Set, Switch
from ecs_eco.config.models.reproduction import Spread
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.mutable_keys import refused
from ecs_eco.engine.errors import ConfigError, Problem, listed, unknown
from ecs_eco.engine.section import Section

Changed = Callable[[WorldConfig, Mapping[str, Any], Path], WorldConfig]


def check_interventions(config: WorldConfig, folder: Path, changed: Changed) -> Iterator[Problem]:
    """All problems of interventions; `changed(config, values, folder)` is a checked world with other values."""
    for i, intervention in enumerate(config.interventions):
        key = ("interventions", i)
        yield from _check_time(config, key, intervention)
        if isinstance(intervention, Cull | Add):
            yield from _check_who(config, key, intervention)
        if isinstance(intervention, Cull | Add | Dose | Fence) and intervention.region is not None:
            yield from check_region((*key, "region"), intervention.region, config)
        if isinstance(intervention, Add):
            yield from _check_add(config, key, intervention)
        elif isinstance(intervention, Dose):
            yield from _check_dose(config, key, intervention)
        elif isinstance(intervention, Switch):
            yield from _check_switch(config, key, intervention)
    yield from _check_fences(config)
    yield from _check_roads(config)
    yield from _check_sets(config, folder, changed)


def _check_time(config: WorldConfig, key: Key, intervention: Any) -> Iterator[Problem]:
    if intervention.at >= config.ticks:
        allowed = f"0 to {config.ticks - 1}, or a larger `ticks` of the world"
        yield Problem(
            (*key, "at"), f"never happens: a run has {config.ticks} ticks", intervention.at, allowed
        )
    if intervention.until is not None and intervention.every is None:
        yield Problem((*key, "until"), "given without every", intervention.until, "both, or neither")
    elif intervention.until is not None and intervention.until < intervention.at:
        yield Problem((*key, "until"), "before at", intervention.until, f"at least {intervention.at}")


def _check_who(config: WorldConfig, key: Key, intervention: Cull | Add) -> Iterator[Problem]:
    if intervention.species not in (*config.species, *config.objects):
        yield unknown(
            (*key, "species"),
            "species or object type",
            intervention.species,
            [*config.species, *config.objects],
        )
    if isinstance(intervention, Cull):
        if (intervention.share, intervention.count, intervention.uids).count(None) != 2:
            yield Problem(
                (*key, "share"),
                "give exactly one of share, count and uids",
                allowed="share = 0.5, count = 20, or uids = [7]",
            )
        if intervention.which in ("richest", "poorest") and intervention.species in config.objects:
            yield Problem(
                (*key, "which"), "objects have no energy", intervention.which, "random, oldest, youngest"
            )


def check_region(key: Key, region: list[float], config: WorldConfig) -> Iterator[Problem]:
    """Problems of a region that is not in the world."""
    size = config.space.size[:2]
    extent = " and ".join(f"0 to {s:g} m" for s in size)
    if len(region) == 4:
        for low, high, length, axis in zip(region[:2], region[2:], size, "xy", strict=True):
            if low < 0 or high > length:
                yield Problem(key, f"outside of the world along {axis}", region, f"{REGION}, within {extent}")
            elif low >= high:
                yield Problem(
                    key, f"without extent along {axis}: {axis}0 is not less than {axis}1", region, REGION
                )
        return
    most = min(size) / 2 if config.space.edges == "torus" else math.hypot(*size)
    if not all(0 <= x <= length for x, length in zip(region, size, strict=False)):
        yield Problem(key, "its centre is outside of the world", region, f"{REGION}, within {extent}")
    if not 0 < region[2] <= most:
        yield Problem(key, f"a radius of {region[2]:g} m", region, f"more than 0, at most {most:g} m")


def _check_add(config: WorldConfig, key: Key, add: Add) -> Iterator[Problem]:
    kind, place, size = config.species.get(add.species), add.at_place, config.space.size
    if kind is not None and kind.max_count is not None and add.count > kind.max_count:
        yield Problem(
            (*key, "count"), f"more than max_count of {add.species}", add.count, f"at most {kind.max_count}"
        )
    if place is None:
        return
    at = (*key, "at_place")
    if add.region is not None:
        yield Problem(at, "given together with region", place, "one of the two")
    if len(place) != len(size):
        yield Problem(at, "wrong number of coordinates", place, f"{len(size)} numbers [m]")
    elif not all(0 <= x < length for x, length in zip(place, size, strict=True)):
        yield Problem(at, "outside of the world", place, " and ".join(f"0 to {s:g} m" for s in size))
    elif config.terrain is not None:
        for group in ("rocks", "lakes"):
            for i, mark in enumerate(getattr(config.terrain, group)):
                if math.dist(mark.at, place[:2]) < mark.radius:
                    yield Problem(at, f"within terrain.{group}.{i}", place, "a place on open ground")
    if kind is not None and isinstance(kind.reproduction, Spread) and add.count > 1:
        yield Problem(
            (*key, "count"),
            f"one site holds one {add.species}",
            add.count,
            "count = 1, or a region instead of at_place",
        )


def _check_dose(config: WorldConfig, key: Key, dose: Dose) -> Iterator[Problem]:
    if (dose.field is None) == (dose.species is None):
        yield Problem(
            (*key, "field"),
            "give exactly one of field and species",
            allowed='field = "soil", or species = "deer" with a substance',
        )
    elif dose.field is not None:
        if dose.field not in config.fields:
            yield unknown((*key, "field"), "field", dose.field, config.fields)
        if dose.substance is not None:
            yield Problem(
                (*key, "substance"), "given together with field", dose.substance, "none: a field has its own"
            )
    else:
        kinds: dict[str, Any] = {**config.objects, **config.species}
        holders = [name for name, kind in kinds.items() if kind.substances]
        if dose.species not in holders:
            yield unknown(
                (*key, "species"), "species or object type with substances", str(dose.species), holders
            )
        if dose.substance is None:
            yield Problem((*key, "substance"), "is missing", allowed=listed(config.substances))
        elif dose.substance not in config.substances:
            yield unknown((*key, "substance"), "substance", str(dose.substance), config.substances)
    if dose.amount == 0:
        yield Problem((*key, "amount"), "no dose", 0.0, "more or less than 0")


def _check_switch(config: WorldConfig, key: Key, switch: Switch) -> Iterator[Problem]:
    if switch.reproduction is None and switch.learning is None:
        yield Problem(
            (*key, "reproduction"),
            "is missing, and learning too",
            allowed="true or false for one of them, or both",
        )
    if switch.species is None:
        return
    if switch.species not in config.species:
        yield unknown((*key, "species"), "species", switch.species, config.species)
    elif switch.learning and not learns(config.species[switch.species]):
        yield Problem(
            (*key, "learning"),
            f"{switch.species} cannot learn",
            True,
            "a species with a policy network and happiness",
        )


def learns(species: Section) -> bool:
    """Whether a species has what learning needs."""
    return species.policy.thinks and species.happiness is not None  # type: ignore[attr-defined]


def _check_fences(config: WorldConfig) -> Iterator[Problem]:
    """Fences in the order of time: a fence must stand to be removed."""
    standing: list[tuple[Any, Any]] = []
    fences = [(i, f) for i, f in enumerate(config.interventions) if isinstance(f, Fence)]
    for i, fence in sorted(fences, key=lambda pair: pair[1].at):
        key = ("interventions", i)
        if fence.line is not None and fence.region is not None:
            yield Problem((*key, "region"), "given together with line", fence.region, "one of the two")
        elif fence.line is None and fence.region is None and not fence.remove:
            yield Problem(
                (*key, "line"), "is missing, and region too", allowed="corners [[x, y], …], or a region"
            )
        yield from check_line((*key, "line"), fence.line or [], config)
        shape = (fence.line, fence.region)
        if not fence.remove:
            standing.append(shape)
        elif shape == (None, None):
            standing.clear()
        elif shape in standing:
            standing.remove(shape)
        else:
            allowed = "the line or region of a fence put up before, or neither for all fences"
            yield Problem((*key, "remove"), "no such fence stands then", True, allowed)


def _check_roads(config: WorldConfig) -> Iterator[Problem]:
    """Roads in the order of time: a road must lie to be taken away."""
    lying: list[Any] = [] if config.terrain is None else [road.line for road in config.terrain.roads]
    roads = [(i, r) for i, r in enumerate(config.interventions) if isinstance(r, Road)]
    for i, road in sorted(roads, key=lambda pair: pair[1].at):
        key = ("interventions", i)
        if road.line is None and not road.remove:
            yield Problem((*key, "line"), "is missing", allowed="corners [[x, y], …]")
        yield from check_line((*key, "line"), road.line or [], config)
        if not road.remove:
            lying.append(road.line)
        elif road.line is None:
            lying.clear()
        elif road.line in lying:
            lying.remove(road.line)
        else:
            yield Problem(
                (*key, "remove"),
                "no such road lies there then",
                True,
                "the line of a road laid before, or none for all roads",
            )


def check_line(key: Key, line: list[Any], config: WorldConfig) -> Iterator[Problem]:
    """Problems of corners [x, y] [m] outside of the world."""
    for corner in line:
        if not all(0 <= x <= s for x, s in zip(corner, config.space.size, strict=False)):
            extent = " and ".join(f"0 to {s:g} m" for s in config.space.size[:2])
            yield Problem(key, "a corner outside of the world", corner, extent)


def _check_sets(config: WorldConfig, folder: Path, changed: Changed) -> Iterator[Problem]:
    """Values to be set, in the order of time: each must leave a valid world and be possible in a living one."""
    now = None
    sets = [(i, s) for i, s in enumerate(config.interventions) if isinstance(s, Set)]
    for i, change in sorted(sets, key=lambda pair: pair[1].at):
        key = ("interventions", i, "set")
        if any(name.partition(".")[0] == "interventions" for name in change.set):
            yield Problem(key, "interventions cannot change others", allowed="keys of the rest of the world")
            continue
        now = config if now is None else now
        try:
            new = changed(now, change.set, folder)
            problems = refused(now, new)
        except ConfigError as error:
            new, problems = now, error.problems
        for p in problems:
            written = next((k for k in change.set if p.path == k or p.path.endswith(k)), None)
            where = "" if written is not None else f", at {p.path}"
            yield p.moved(
                key=key if written is None else (*key, written), what=p.what + where, source="", line=None
            )
        now = now if problems else new
