"""Exchange: bodies take up substances of fields, and give them off."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.config.features.substances import check_action, check_held
from ecs_eco.engine.errors import Problem, unknown
from ecs_eco.engine.section import (
    FREE,
    SHAPE,
    NonNegative,
    Point,
    Positive,
    Section,
    about,
    is_absent,
    quantity,
)


class Uptake(Section, change=FREE, own=True):
    """Takes the substance of a field up from where the mouth is: breathes, drinks, sucks with its roots.

    At most rate × c/(half + c) × volume × dt in a tick, c being the concentration there; where bodies want
    more than there is, each gets the same share of what it wants.
    """

    kind: Literal["uptake"]
    field: str = about("a field of a substance")
    rate: Positive = quantity("most that a litre of the body takes up in a second", "mol/(L s)")
    half: Positive | None = quantity(
        "concentration in the field at which it takes up half as much "
        "(Michaelis & Menten 1913); absent: as much at any",
        "mol/L",
        None,
    )
    until: Positive | None = quantity(
        "takes no more up at this concentration in its body; absent: always", "mol/L", None
    )
    at: Point = quantity("place of the mouth: forward, left (, up), in radii of the body", "1", [0.0, 0.0])
    action: str | None = about("the action by which it does so, in a group of any name; absent: always", None)


class Release(Section, change=FREE, own=True):
    """Gives a substance off: excretes, sweats, exhales or leaks it, dc/dt = −rate (c − above)."""

    kind: Literal["release"]
    substance: str = about("what it gives off")
    field: str | None = about("a field of this substance that it goes into; absent: it is lost", None)
    rate: Positive = quantity("share given off in a second", "1/s")
    above: NonNegative = quantity("concentration in its body that it keeps", "mol/L", 0.0)
    at: Point = quantity(
        "place where it comes out: forward, left (, up), in radii of the body", "1", [0.0, 0.0]
    )
    action: str | None = about("the action by which it does so, in a group of any name; absent: always", None)


class Equilibrate(Section, change=FREE, own=True):
    """Lets a substance pass through the skin, dc/dt = rate (partition × c_field − c), in both directions.

    This is Fick's law (1855) with rate = permeability × surface / volume; it is solved exactly for a body and
    its share, by volume, of the cell of the field that it is in.
    """

    kind: Literal["equilibrate"]
    field: str = about("a field of a substance")
    rate: Positive = quantity("share of the difference that vanishes in a second, in a large field", "1/s")
    partition: Positive = quantity(
        "concentration in the body over that in the field where they balance", "1", 1.0
    )
    at: Point = quantity(
        "place of the gills or the skin: forward, left (, up), in radii of the body", "1", [0.0, 0.0]
    )


AnyExchange = Annotated[Uptake | Release | Equilibrate, Field(discriminator="kind")]


class Exchanging(Feature, after="reactions"):
    """Organisms and objects exchange substances with fields: system `ExchangeMatter`, component `Matter`."""

    exchange: list[AnyExchange] = about(
        "what it takes up from fields and gives off, in this order", [], exclude_if=is_absent, change=SHAPE
    )

    @staticmethod
    def problems(species: Exchanging, config: WorldSections, key: Key) -> Iterator[Problem]:
        """Yield exchange of no substance, with no field of it, and by no action."""
        yield from check_held(species, config, key, "exchange")
        holding = {name: f.substance for name, f in config.fields.items() if f.substance is not None}
        for i, way in enumerate(species.exchange):
            at, released = (*key, "exchange", i), way.substance if isinstance(way, Release) else None
            if released is not None and released not in config.substances:
                yield unknown((*at, "substance"), "substance", released, config.substances)
            if way.field is not None and way.field not in holding:
                yield unknown((*at, "field"), "field of a substance", way.field, holding)
            elif way.field is not None and released not in (None, held := holding[way.field]):
                yield Problem((*at, "field"), f"it holds {held}", way.field, f"a field of {released}")
            yield from check_action(species, (*at, "action"), getattr(way, "action", None))
