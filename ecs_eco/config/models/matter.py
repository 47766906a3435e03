"""How the substances of bodies change: reactions, exchange with fields, decay."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, create_model

from ecs_eco.engine.section import (
    CHEMISTRY,
    FREE,
    Name,
    NonNegative,
    Point,
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


class Decomposition(Section, change=FREE):
    """Decay: what it holds goes into the first field of each substance, dc/dt = −rate c (Olson 1963), or is
    lost where there is none; the object vanishes when little is left."""

    rate: Positive = quantity("share given back in a second", "1/s")
    left: Annotated[float, Field(gt=0, lt=1)] = quantity(
        "share after whose time it gives back the rest at once and vanishes", "1", 0.01
    )
