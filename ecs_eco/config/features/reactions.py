"""Reactions: bodies turn substances into others, and into energy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic import create_model

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.config.features.substances import check_action, check_held
from ecs_eco.engine.errors import Problem, unknown
from ecs_eco.engine.section import (
    CHEMISTRY,
    FREE,
    SHAPE,
    Name,
    Positive,
    Real,
    Section,
    about,
    is_absent,
    quantity,
)

Amounts = dict[Name, Positive]
# `from` is a keyword of Python and no name that a class body could give to a field
_From: Any = create_model(
    "_From",
    __base__=Section,
    **{
        "from": (  # type: ignore[call-overload]
            Amounts,
            quantity("substance = amount used up per mole of extent", "mol/mol", min_length=1, own=CHEMISTRY),
        )
    },
)


class Reaction(_From, change=FREE, own=True):  # type: ignore[call-arg]
    """A reaction within the body: at most at its rate, and only as far as what it uses up is there.

    The extent in a tick is rate × Π c/(half + c) × volume × dt over the substances under `half` (Michaelis &
    Menten 1913; Monod 1949), times the light at its place with `light`. A reaction that sets energy free
    stops where the organism is full, one that needs energy where it has none.
    """

    to: Amounts = quantity("substance = amount made per mole of extent", "mol/mol", {}, own=CHEMISTRY)
    energy: Real = quantity(
        "energy that a mole of extent gives to the organism, negative: takes from it", "energy/mol", 0.0
    )
    rate: Positive = quantity("greatest extent in a second and a litre of the body", "mol/(L s)")
    half: Amounts = quantity(
        "substance = concentration at which the rate is half of its greatest; "
        "a substance not named does not slow it",
        "mol/L",
        {},
    )
    light: bool = about("whether it needs light: its rate is that in full daylight", False)
    action: str | None = about(
        "the action that it goes with, in any group: muscles that run burn sugar; absent: always",
        None,
        exclude_if=is_absent,
    )


class Reacting(Feature, after="substances"):
    """Substances react in organisms and objects: system `React`, component `Matter`."""

    reactions: list[Reaction] = about(
        "reactions of its substances, in this order", [], exclude_if=is_absent, change=SHAPE
    )

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        """Yield reactions of no substances, for energy that objects do not hold, and by no action."""
        yield from check_held(species, config, key, "reactions")
        for i, reaction in enumerate(species.reactions):
            at = (*key, "reactions", i)
            for part in ("from", "to", "half"):
                for name in getattr(reaction, part):
                    if name not in config.substances:
                        yield unknown((*at, part, name), "substance", name, config.substances)
            if reaction.energy and key[0] == "objects":
                yield Problem((*at, "energy"), "objects hold no energy", reaction.energy, "0")
            yield from check_action(species, (*at, "action"), reaction.action)
