"""Chemistry of the substances in bodies: reactions, exchange, births, decomposition, emissions."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.config.rules import named
from ecs_eco.engine.errors import Problem, unknown
from ecs_eco.inputs.section import (
    CHEMISTRY,
    FREE,
    SHAPE,
    Name,
    NonNegative,
    Point,
    Positive,
    Real,
    Section,
    about,
    quantity,
    table,
    with_keyword,
)

CHANGING = ("reactions", "exchange", "decomposition", "born_with")  # keys whose sections change substances
Amounts = dict[Name, Positive]
_From: Any = with_keyword(
    "from",
    Amounts,
    quantity("substance = amount consumed per mole of extent", "mol/mol", min_length=1, own=CHEMISTRY),
)


class Reaction(_From, change=FREE, own=True):  # type: ignore[call-arg]
    """A reaction within the body, limited by its rate and its reactants.

    The extent in a tick is rate × Π c/(half + c) × volume × dt over the substances under `half` (Michaelis &
    Menten 1913; Monod 1949), times the light at the body's position if `light` is set. A reaction that releases
    energy stops when the organism's store is full; a reaction that needs energy stops when the store is
    empty.
    """

    to: Amounts = quantity("substance = amount produced per mole of extent", "mol/mol", {}, own=CHEMISTRY)
    energy: Real = quantity(
        "energy gained by the organism per mole of extent; negative: it needs energy", "energy/mol", 0.0
    )
    rate: Positive = quantity("maximum extent per second and liter of body", "mol/(L s)")
    half: Amounts = quantity(
        "substance = concentration at half the maximum rate; other substances do not limit it", "mol/L", {}
    )
    light: bool = about("whether it needs light; `rate` is then the rate in full daylight", False)
    action: str | None = about(
        "the action, in any group, during which it runs, such as a gait that burns sugar; default: always",
        omit=True,
    )


class Uptake(Section, change=FREE, own=True):
    """Uptake of a substance from a field at the mouth: breathing, drinking, absorption by roots.

    Uptake in a tick is at most rate × c/(half + c) × volume × dt, where c is the concentration at the mouth; if
    total demand exceeds the supply, each body gets the same proportion of its demand.
    """

    kind: Literal["uptake"]
    field: str = about("a field of a substance")
    rate: Positive = quantity("maximum uptake per second and liter of body", "mol/(L s)")
    half: Positive | None = quantity(
        "concentration in the field at half the maximum uptake (Michaelis & Menten 1913); default: the "
        "uptake does not depend on it",
        "mol/L",
        None,
    )
    concentration_max: Positive | None = quantity(
        "concentration in the body at which uptake stops; default: no limit", "mol/L", None, former="until"
    )
    at: Point = quantity("position of the mouth: forward, left (, up), in body radii", "1", [0.0, 0.0])
    action: str | None = about("the action, in any group, during which it runs; default: always", None)


class Release(Section, change=FREE, own=True):
    """Release of a substance by excretion, sweat, breath or leakage, dc/dt = −rate (c − above)."""

    kind: Literal["release"]
    substance: str = about("the substance that it releases")
    field: str | None = about("a field of this substance that receives it; default: it is lost", None)
    rate: Positive = quantity("proportion released per second", "1/s")
    above: NonNegative = quantity("concentration that remains in its body", "mol/L", 0.0)
    at: Point = quantity("position of the outlet: forward, left (, up), in body radii", "1", [0.0, 0.0])
    action: str | None = about("the action, in any group, during which it runs; default: always", None)


class Equilibrate(Section, change=FREE, own=True):
    """Passage of a substance through the skin in both directions, dc/dt = rate (partition × c_field − c).

    This is Fick's law (1855) with rate = permeability × surface / volume; it is solved exactly for a body and
    its share, by volume, of the field's cell.
    """

    kind: Literal["equilibrate"]
    field: str = about("a field of a substance")
    rate: Positive = quantity("proportion of the difference lost per second, in a large field", "1/s")
    partition: Positive = quantity("ratio of body to field concentration at equilibrium", "1", 1.0)
    at: Point = quantity(
        "position of the gills or skin: forward, left (, up), in body radii", "1", [0.0, 0.0]
    )


AnyExchange = Annotated[Uptake | Release | Equilibrate, Field(discriminator="kind")]


class Chemistry(Feature, after="substances"):
    """Substances react and move to and from fields: systems `React`, `ExchangeMatter`, component `Matter`."""

    reactions: list[Reaction] = about(
        "reactions of its substances, in this order", [], omit=True, change=SHAPE
    )
    exchange: list[AnyExchange] = about(
        "exchange of substances with fields; in each tick, uptake comes first, then equilibration, then release",
        [],
        omit=True,
        change=SHAPE,
    )

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        used = [name for name in CHANGING if getattr(species, name, None) not in (None, [], "declared")]
        if used and not substances_of(config, key[1]):
            allowed = "initial concentrations [mol/L], which may be 0"
            yield Problem((*key, "substances"), f"is missing, but {used[0]} changes them", allowed=allowed)
        for i, reaction in enumerate(species.reactions):
            at = (*key, "reactions", i)
            for part in ("from", "to", "half"):
                for name in getattr(reaction, part):
                    yield from named((*at, part, name), "substance", name, config.substances)
            if reaction.energy and key[0] == "objects":
                yield Problem((*at, "energy"), "objects have no energy budget", reaction.energy, "0")
            yield from check_action(species, (*at, "action"), reaction.action)
        holding = {name: f.substance for name, f in config.fields.items() if f.substance is not None}
        for i, way in enumerate(species.exchange):
            at, released = (*key, "exchange", i), way.substance if isinstance(way, Release) else None
            if released is not None and released not in config.substances:
                yield unknown((*at, "substance"), "substance", released, config.substances)
            if way.field is not None and way.field not in holding:
                yield unknown((*at, "field"), "field of a substance", way.field, holding)
            elif way.field is not None and released not in (None, held := holding[way.field]):
                yield Problem((*at, "field"), f"it contains {held}", way.field, f"a field of {released}")
            yield from check_action(species, (*at, "action"), getattr(way, "action", None))


class Provision(Feature, after="exchange"):
    """Newborns get substances from their mother or from the soil: systems `Provide` and `Spread`."""

    born_with: Literal["declared", "mother", "soil"] = about(
        "origin of newborns' substances; declared: created from nothing; mother: the mother shares hers, so "
        "that concentrations are equal; soil: taken from each substance's first field; seeds germinate only where "
        "there is enough",
        "declared",
        omit=True,
        change=SHAPE,
    )

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        at, kind = (*key, "born_with"), getattr(species.reproduction, "kind", None)
        if species.born_with == "mother" and kind in (None, "spread"):
            yield Problem(
                at, "it has no mother", "mother", "declared or soil, or another kind of reproduction"
            )
        if species.born_with != "soil":
            return
        if kind != "spread":
            yield Problem(
                at, "it has no seeds", "soil", 'declared or mother, or reproduction.kind = "spread"'
            )
        held = {field.substance for field in config.fields.values()}
        for name, concentration in species.substances.items():
            if concentration > 0 and name not in held:
                fault = "newborns take it from the soil, but no field contains it"
                allowed = "0, or a field with this substance"
                yield Problem((*key, "substances", name), fault, concentration, allowed)


class Decomposition(Section, change=FREE):
    """Decay: each substance passes into its first field, dc/dt = −rate c (Olson 1963), or is lost if it has
    no field; the object vanishes when little is left."""

    rate: Positive = quantity("proportion returned per second", "1/s")
    left: Annotated[float, Field(gt=0, lt=1)] = quantity(
        "remaining fraction at which the object returns the rest at once and vanishes", "1", 0.01
    )


class Decomposing(Feature, after="exchange"):
    """Objects decay: system `Decompose`, component `Matter`."""

    decomposition: Decomposition | None = about("decay; absent: no decay", omit=True, change=SHAPE)

    @staticmethod
    def causes(species: "Decomposing", key: Key) -> Iterator[tuple[Key, str]]:
        if species.decomposition is not None:
            yield (*key, "decomposition"), "decomposed"


class Emission(Section, own=True):
    """A smell given off by a substance in the body: rate × its amount in the body [mol] per second."""

    substance: str = about("the substance that gives off the smell")
    rate: NonNegative = quantity(
        "amount emitted per second, as a proportion of the substance in the body", "1/s"
    )
    consume: bool = about("whether the body loses the amount emitted", False, change=SHAPE)


class Emitting(Feature, after=("defence", "decomposition")):
    """Organisms and objects emit into fields: system `Diffuse`."""

    emits: dict[Name, NonNegative | Emission] = table(
        "field = amount emitted into it [1/s], or { substance, rate, consume }", dict, change=FREE, own=True
    )

    @staticmethod
    def problems(species: "Emitting", config: WorldSections, key: Key) -> Iterator[Problem]:
        for name, way in species.emits.items():
            at, holds = (*key, "emits", name), getattr(config.fields.get(name), "substance", None)
            yield from named(at, "field", name, config.fields)
            if isinstance(way, Emission) and way.substance not in config.substances:
                yield unknown((*at, "substance"), "substance", way.substance, config.substances)
            elif isinstance(way, Emission) and not substances_of(config, key[1]):
                fault = "its bodies contain no substances"
                yield Problem((*at, "substance"), fault, way.substance, "substances, or a number")
            elif holds and not (isinstance(way, Emission) and way.consume and way.substance == holds):
                fault = f"the field contains {holds}, which cannot come from nothing"
                allowed = f'{{ substance = "{holds}", rate = …, consume = true }}, or `exchange`'
                yield Problem(at, fault, allowed=allowed)

    @staticmethod
    def undivided(species: Any) -> Iterator[tuple[str, str]]:
        if any(isinstance(way, Emission) for way in species.emits.values()):
            yield "emits", "that emits substances from its bodies"


def substances_of(config: WorldSections, name: str | int) -> set[str]:
    """Return the substances declared for a kind of body; for remains, also the dead organisms' substances."""
    kind = config.species.get(str(name)) or config.objects[str(name)]
    dead = [s.substances for s in config.species.values() if s.remains == name]
    return {substance for held in (kind.substances, *dead) for substance in held}


def check_action(kind: Any, at: Key, action: str | None) -> Iterator[Problem]:
    """Yield problems with an action during which a species changes its substances."""
    if action is None:
        return
    if at[0] == "objects":
        yield Problem(at, "objects do not act", action, "no action")
    elif action not in (rows := kind.action_rows()):
        yield unknown(at, "action of the species", action, rows)
    elif kind.action_list()[rows[action]][0] in kind.ranges():
        yield Problem(at, "is continuous", action, "a categorical action")
