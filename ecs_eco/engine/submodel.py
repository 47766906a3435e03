"""The declaration of a system or a section for the description of a world (ODD)."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Submodel(NamedTuple):
    """A submodel of the ODD that `ecs-eco describe` writes, next to the system or section that carries it out.

    Keys are those of a species, an object type or the world file: "diet.gain" applies where a value is neither
    absent, 0, false nor empty, "reproduction.kind=sexual" where it has this value, "Defence" where the table has
    this component.
    """

    title: str = ""
    """Its heading; systems and sections of the same title share it. Bookkeeping has none."""
    where: tuple[str, ...] = ()
    """Keys of which one must apply to a kind for the system to act on it; without any, it acts on all."""
    reads: tuple[str, ...] = ()
    """Keys whose values are its parameters."""
    rules: Mapping[str, str] = MappingProxyType({})
    """Equations and sentences, by the key where they apply; "" applies always."""
    changes: tuple[str, ...] = ()
    """The state variables that it changes: components, or Component.field."""
    draws: str = ""
    """Its random draws."""
