"""Rules shared by the checks of several sections; each yields the problems that it finds."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Protocol

from ecs_eco.engine.errors import Problem, listed, nearest, unknown

Key = tuple[str | int, ...]


class WorldSections(Protocol):
    """The attributes of a `WorldConfig` that checks across sections read."""

    species: Any
    objects: Any
    fields: Any
    substances: Any
    space: Any
    sun: Any
    year: Any

    def own_fields(self, kind: str) -> dict[str, float]: ...

    def may_have(self, kind: str, name: str) -> bool: ...


def named(key: Key, kind: str, name: str, known: Iterable[str]) -> Iterator[Problem]:
    """Yield a problem if a name is not one of the known names."""
    if name not in known:
        yield unknown(key, kind, name, known)


def no_such(key: Key, kind: str, name: str, known: Iterable[str]) -> Problem:
    """Return the problem with a name that the world does not define."""
    known = list(known)
    return Problem(key, f"no such {kind}", name, listed(known), nearest(name, known))


def once(key: Key, names: Sequence[str], allowed: str) -> Iterator[Problem]:
    """Yield a problem for each name that occurs earlier in the same list."""
    for i, name in enumerate(names):
        if name in names[:i]:
            yield Problem((*key, i), "named twice", name, allowed)


def at_most(key: Key, fault: str, value: float, most: float, unit: str = " m") -> Iterator[Problem]:
    """Yield a problem if a value is above its maximum."""
    if value > most:
        yield Problem(key, fault, value, f"at most {most:g}{unit}")


def not_too_fine(
    key: Key,
    whole: str,
    cell: float,
    size: Sequence[float],
    most: int,
    parts: str = "cells",
    or_else: str = "",
) -> Iterator[Problem]:
    """Yield a problem if cells of this width [m] divide a space of this size [m] into more than `most` of them."""
    count = math.prod([max(1.0, side / cell) for side in size])
    if count > most:
        longest = sorted(size, reverse=True)
        least = max((math.prod(longest[:n]) / most) ** (1 / n) for n in range(1, len(size) + 1))
        allowed = f"at least {1.05 * least:.2g} m ({most:,} {parts}){or_else}"  # 1.05: never rounded below
        yield Problem(key, f"too small: the {whole} would have {count:.3g} {parts}", cell, allowed)


def check_objects(config: WorldSections, key: Key, ways: Sequence[Any], distance: str) -> Iterator[Problem]:
    """Yield problems with entries that each name an object type and search for it within a distance."""
    for i, way in enumerate(ways):
        if way.object not in config.objects:
            yield unknown((*key, i, "object"), "object type", way.object, config.objects)
        elif way.object in (other.object for other in ways[:i]):
            allowed = "one entry per object type"
            yield Problem((*key, i, "object"), "named twice", way.object, allowed)
        fault = "above the maximum search distance in this world"
        yield from at_most((*key, i, distance), fault, getattr(way, distance), config.space.widest)


def check_used(species: Any, key: Key, section: str, group: str) -> Iterator[Problem]:
    """Yield a problem if a species has an action group but lacks the section that the group needs."""
    if group in species.actions and not getattr(species, section):
        fault, allowed = (
            f"it {section} nothing",
            f'{section} = [{{ object = "stick", … }}], or remove the group',
        )
        yield Problem((*key, "actions", group), fault, species.actions[group], allowed)


def inside(key: Key, at: Sequence[float], size: Sequence[float]) -> Iterator[Problem]:
    """Yield a problem if a position [m] is outside a space of this size."""
    if len(at) != len(size):
        yield Problem(key, "wrong number of coordinates", at, f"{len(size)} numbers [m]")
    elif not all(0 <= x < length for x, length in zip(at, size, strict=True)):
        yield Problem(key, "outside the world", at, extent(size))


def extent(size: Sequence[float]) -> str:
    """Return the range of coordinates in a space of this size as text."""
    return " and ".join(f"0 to {side:g} m" for side in size)


def written_at(problem: Problem, place: Key, written: str | None, while_: str = "") -> Problem:
    """Return a problem with a derived world, moved to `place` or, if given, to the value `written` there."""
    where = "" if written is not None else f", at {problem.path}{while_}"
    key = place if written is None else (*place, written)
    return problem.moved(key=key, what=problem.what + where, source="", line=None)
