"""Provision: where the substances of newborn come from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.config.features.substances import check_held
from ecs_eco.engine.errors import Problem
from ecs_eco.engine.section import SHAPE, about


class Provision(Feature, after="exchange"):
    """Newborn get substances from their mother, or from the soil: systems `Provide` and `Spread`."""

    born_with: Literal["declared", "mother", "soil"] = about(
        "where the substances of newborn come from: declared: from nowhere; mother: she shares what she "
        "holds, at equal concentration; soil: from the first field of each, where a seed falls, and it "
        "sprouts only where there is enough",
        "declared",
        exclude_if=lambda value: value == "declared",
        change=SHAPE,
    )

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        """Yield newborn without a mother, seeds without soil, and soil that lacks what they need."""
        yield from check_held(species, config, key, "born_with")
        at, kind = (*key, "born_with"), getattr(species.reproduction, "kind", None)
        if species.born_with == "mother" and kind in (None, "spread"):
            yield Problem(at, "it has no mother", "mother", "declared or soil, or another reproduction")
        if species.born_with != "soil":
            return
        if kind != "spread":
            allowed = 'declared or mother, or reproduction.kind = "spread"'
            yield Problem(at, "it has no seeds", "soil", allowed)
        held = {field.substance for field in config.fields.values()}
        for name, concentration in species.substances.items():
            if concentration > 0 and name not in held:
                fault = "no field holds it, and newborn take it from the soil"
                allowed = "0, or a field with this substance"
                yield Problem((*key, "substances", name), fault, concentration, allowed)
