"""The part of a world's description (ODD) that a system or section declares."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Submodel(NamedTuple):
    """A submodel of the ODD that `ecs-eco describe` writes, declared next to the system or section that
    implements it.

    Keys are keys of a species, an object type or the world file: "diet.gain" applies if its value is not
    absent, 0, false or empty, "reproduction.kind=sexual" if the key has this value, and "Defence" if the
    table has this component.
    """

    title: str = ""
    """Its heading, which systems and sections with the same title share. Bookkeeping has none."""
    where: tuple[str, ...] = ()
    """The system acts on a kind if one of these keys applies to that kind; without keys, it acts on all
    kinds."""
    reads: tuple[str, ...] = ()
    """Keys that contain its parameters."""
    rules: Mapping[str, str] = MappingProxyType({})
    """Equations and sentences by the key to which they apply; "" always applies."""
    changes: tuple[str, ...] = ()
    """The state variables that it changes: Component or Component.field."""
    draws: str = ""
    """Its random draws."""
