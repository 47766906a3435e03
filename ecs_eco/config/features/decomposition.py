"""Decomposition: objects give their substances back."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import Field

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.config.features.substances import check_held
from ecs_eco.engine.errors import Problem
from ecs_eco.engine.section import FREE, SHAPE, Positive, Section, about, is_absent, quantity


class Decomposition(Section, change=FREE):
    """Decay: what it holds goes into the first field of each substance, dc/dt = −rate c (Olson 1963), or is
    lost where there is none; the object vanishes when little is left."""

    rate: Positive = quantity("share given back in a second", "1/s")
    left: Annotated[float, Field(gt=0, lt=1)] = quantity(
        "share after whose time it gives back the rest at once and vanishes", "1", 0.01
    )


class Decomposing(Feature, after="exchange"):
    """Objects decay: system `Decompose`, component `Matter`."""

    decomposition: Decomposition | None = about(
        "how they decay; absent: they do not", None, exclude_if=is_absent, change=SHAPE
    )

    @staticmethod
    def problems(species: Decomposing, config: WorldSections, key: Key) -> Iterator[Problem]:
        """Yield that there is nothing to give back."""
        yield from check_held(species, config, key, "decomposition")

    @staticmethod
    def causes(species: Any, key: Key) -> Iterator[tuple[Key, str]]:
        """Yield how objects end."""
        if species.decomposition is not None:
            yield (*key, "decomposition"), "decomposed"
