"""Values of a species that can be heritable, and the columns that store each organism's values."""

from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from typing import Any

import numpy as np

from ecs_eco.config.models.nerves import Connection
from ecs_eco.config.models.species import Species, ppo_defaults
from ecs_eco.config.models.surroundings import PROPERTIES
from ecs_eco.config.numbers import PLACE, Number, numbers_of, values_in
from ecs_eco.genomes.choices import CHOICES
from ecs_eco.genomes.traits import Kind, Trait
from ecs_eco.inputs.section import LARGEST, SMALLEST, Column
from ecs_eco.learning.settings import PPO

TINY = 1e-6  # minimum of traits that must be above 0


def traits_of(species: Species, dims: int, extra_components: Iterable[Any] = ()) -> dict[str, Trait]:
    """Return every trait that this species could make heritable, by name, in a space with `dims` axes.

    Each number in `extra_components`, which users define, is a trait named Component.field. Traits that a
    gene of the species codes for have their index in the component Traits.
    """
    traits = [
        *_of_body(species),
        *_of_sensors(species),
        *_of_nerves(species),
        *_of_learning(species),
        *_of_breeding(species),
        *_of_life(species),
        *_of_section(species),
        *_of_organs(species),
        *(trait for component in extra_components for trait in _of_component(component)),
    ]
    in_traits = {trait.name for trait in traits if trait.component == "Traits"}
    section = species.genome
    coded = [g.trait for g in section.genes] + [d.trait for d in section.derived.values()] if section else []
    places = [trait for trait in coded if trait in in_traits]  # the order of these entries must never change
    return {
        trait.name: replace(trait, index=places.index(trait.name))
        if trait.component == "Traits" and trait.name in places
        else trait
        for trait in traits
    }


def numbers_of_species(model: type[Species] = Species) -> dict[str, Number]:
    """Return every number that a species section can contain, including hyperparameters, by pattern."""
    known = {number.name: number for number in numbers_of(model).values()}
    for field in fields(PPO):
        if field.type in ("int", "float"):
            low, high, above = (field.metadata[word] for word in ("low", "high", "above"))
            number = Number(
                ("ppo", field.name),
                float(low),
                min(float(high), LARGEST),
                above,
                field.type == "int",
                "1",
                field.metadata["doc"],
                field.metadata["own"],
            )
            known[number.name] = number
    return known


def why_shared(key: str, model: type[Species] = Species) -> str:
    """Return why organisms cannot have individual values for a key of their species, or ""."""
    parts = key.split(".")
    for number in numbers_of_species(model).values():
        fits = len(number.pattern) == len(parts) and all(
            a in (PLACE, b) for a, b in zip(number.pattern, parts, strict=True)
        )
        if fits and number.own is not None and not number.codable:
            return str(number.own)
    return ""


def label_of(connection: Connection) -> str:
    """Return the name that genes use for a reflex connection: its `name`, or SENSOR_ACTION."""
    return connection.name or f"{connection.sensor}_{connection.action}"


def _trait(
    name: str,
    component: str,
    own: float,
    text: str,
    unit: str = "1",
    low: float = 0.0,
    high: float = LARGEST,
    kind: Kind = "number",
    field: str = "",
    index: int | None = None,
) -> Trait:
    """Return a trait; unless given, its field is the last part of its name."""
    return Trait(name, component, field or name.rpartition(".")[2], index, own, low, high, kind, unit, text)


def _of_body(species: Species) -> Iterator[Trait]:
    body, owner = species.body, "Body" if species.growth is None else "Stature"
    yield _trait("body.radius", owner, body.radius, "radius of the body", "m", TINY)
    yield _trait("body.mass", owner, body.mass, "mass of the body", "kg", TINY)
    if species.locomotion is not None:
        text = "factor for all speeds; the cost of moving increases with its square"
        yield _trait("locomotion.pace", "SpeedScale", 1.0, text)
    for name, value in species.properties.items():
        text, unit = f"{name.replace('_', ' ')} at birth", PROPERTIES.get(name, "1")
        yield _trait(f"properties.{name}", "Physical", value, text, unit, -LARGEST)


def _of_section(species: Species) -> Iterator[Trait]:
    """Yield the section's numbers that are stored in Traits or in a declared column."""
    for number, key, value in values_in(species):
        if number.own is True and key != ("lethal", "age", "max"):
            low = SMALLEST if number.above and number.low == 0 else number.low
            yield _kept(".".join(key), value, number, low)
        elif isinstance(way := number.own, Column):
            span = number.low, number.high
            yield _trait(
                ".".join(key), way.component, value, number.text, number.unit, *span, field=way.field
            )


def _kept(name: str, own: float, number: Number, low: float) -> Trait:
    """Return the trait of a number that is stored in Traits."""
    kind: Kind = "whole" if number.whole else "number"
    return _trait(name, "Traits", own, number.text, number.unit, low, number.high, kind, "value")


def _of_sensors(species: Species) -> Iterator[Trait]:
    for i, sensor in enumerate(species.sensors):
        name = f"sensors.{sensor.name}"
        if (reach := getattr(sensor, "range", None)) is not None:
            text = f"range of the sensor {sensor.name}"
            yield _trait(f"{name}.range", "Senses", reach, text, "m", TINY, field="radius", index=i)
        if (at := getattr(sensor, "at", None)) is None or sensor.kind in ("touch", "own"):
            continue  # only the vertical position matters within its own body, and no gene codes for it
        for own, way in zip(at, ("forward", "left"), strict=False):
            text = f"position of the sensor {sensor.name} on the body, {way}, in body radii"
            yield _trait(f"{name}.{way}", "Senses", own, text, low=-LARGEST, index=i)


def _of_nerves(species: Species) -> Iterator[Trait]:
    for i, c in enumerate(species.reflex.connections if species.reflex else ()):
        name, way = f"reflex.{label_of(c)}", "above" if c.above is not None else "below"
        text = (
            f"while {c.sensor} is {way} the threshold: −1 blocks {c.action}, 0 leaves it to the policy, "
            "1 forces it"
        )
        yield _trait(f"{name}.weight", "Reflexes", c.weight, text, "1", -1.0, 1.0, "sign", index=i)
        own, text = getattr(c, way) or 0.0, f"{c.action} responds to {c.sensor} {way} this reading"
        yield _trait(f"{name}.threshold", "Reflexes", float(own), text, "reading", -LARGEST, index=i)
    for i, (channel, weight) in enumerate(species.happiness.weights.items() if species.happiness else ()):
        text = f"contribution of {channel} to happiness"
        yield _trait(
            f"happiness.{channel}", "HappinessWeights", weight, text, low=-LARGEST, field="weight", index=i
        )
    for word in ("reflex", "happiness"):  # made by `fit_network`; only evolution changes the weights
        if getattr(getattr(species, word), "function", None) is not None:
            text = f"weights of its {word} network, if fit_network created the function"
            yield _trait(f"{word}.weights", "Instincts", 0.0, text, "1", -LARGEST, kind="weights", field=word)


def _of_learning(species: Species) -> Iterator[Trait]:
    if species.policy.kind != "individual":
        return
    text = "weights of the policy network at birth"
    yield _trait("policy.weights", "Policy", 0.0, text, low=-LARGEST, kind="weights")
    settings = ppo_defaults() | species.ppo
    for field, high in {"learning_rate": LARGEST, "discount": 1.0, "entropy_coef": LARGEST}.items():
        # other values are reported elsewhere
        own = float(settings[field]) if isinstance(settings[field], int | float) else 0.0
        text = f"{field.replace('_', ' ')} of its learning by PPO"
        yield _trait(f"ppo.{field}", "LearningRates", own, text, high=high, field=field.removesuffix("_coef"))
    if species.policy.network is not None or species.ranges():
        return  # torch learns with the species' hyperparameters
    for name, number in numbers_of_species().items():
        value = settings.get(name.removeprefix("ppo."))
        if name.startswith("ppo.") and number.own is True and isinstance(value, int | float):
            yield _kept(name, float(value), number, SMALLEST if number.above else number.low)


def _of_breeding(species: Species) -> Iterator[Trait]:
    way, own = species.breeding, species.fertility
    if way is None:
        if getattr(species.reproduction, "kind", "spread") != "spread":  # otherwise nothing uses it
            yield _trait("fertility", "Biology", own, "fertility", high=1.0)
        return
    yield _trait("fertility", "Breeding", own, "its maximum fertility", high=1.0, field="peak")
    ages = {
        "maturity": (way.maturity, "age from which it is fertile"),
        "prime": (way.age_of_prime(), "age at which it is most fertile"),
        "end": (LARGEST if way.end is None else way.end, "age at which fertility ends"),
    }
    for field, (own, text) in ages.items():
        yield _trait(f"breeding.{field}", "Breeding", own, text, "s")
    if way.season is not None:
        text = "time of the year when it is most fertile"
        yield _trait("breeding.season", "Breeding", way.season, text, high=1.0)
        text = "length of its breeding season: standard deviation, as a fraction of a year"
        yield _trait("breeding.width", "Breeding", way.width, text, high=1.0)


def _of_life(species: Species) -> Iterator[Trait]:
    age = next((x.max for x in species.lethal if x.property == "age" and x.max is not None), None)
    if age is not None:
        yield _trait("life.age_max", "LifeHistory", age, "age at which it dies", "s", TINY)
    way = species.reproduction
    if way is not None and way.kind == "spread":
        yield _trait("reproduction.spread", "Growth", 1.0, "proportion of its seeds that germinate", high=1.0)
    whom = "choice of mates: 0 the nearest, 1 any, 2 the mate with the most energy, 3 the oldest"
    fields: dict[str, tuple[float, float, Kind, str, str]] = {
        "age_min": (0.0, LARGEST, "number", "s", "minimum age to reproduce"),
        "energy_min": (0.0, LARGEST, "number", "energy", "minimum energy to reproduce"),
        "energy_given": (0.0, LARGEST, "number", "energy", "energy of each newborn"),
        "litter": (1.0, 10_000.0, "whole", "1", "litter size"),
        "choice": (0.0, 3.0, "whole", "1", whom),
    }
    for field, (low, high, kind, unit, text) in fields.items():
        if (value := getattr(way, field, None)) is not None:
            own = float(CHOICES.index(value) if field == "choice" else value)
            yield _trait(f"reproduction.{field}", "LifeHistory", own, text, unit, low, high, kind)


def _of_organs(species: Species) -> Iterator[Trait]:
    """Yield an organism's switches for sensors and actions, and its numbers of hidden units."""
    switches = {
        f"sensors.{s.name}.present": f"whether it has the sensor {s.name}; if absent, it reads 0"
        for s in species.sensors
    }
    switches |= {
        f"actions.{group}.{action}.present": f"whether it can do {action}; if absent, it never does"
        for group, action in species.action_list()
    }
    for name, text in switches.items():
        yield _trait(name, "Traits", 1.0, text, high=1.0, kind="whole", field="value")
    if species.policy.kind == "individual" and species.policy.network is None and not species.ranges():
        for i, units in enumerate(species.policy.hidden):
            text = f"units in hidden layer {i} of its policy network"
            yield _trait(f"policy.hidden.{i}", "Traits", units, text, "1", 1.0, units, "whole", "value")


def _of_component(component: type[Any]) -> Iterator[Trait]:
    spans: dict[str, tuple[float, float, Kind]] = {
        "f": (-LARGEST, LARGEST, "number"),
        "b": (0.0, 1.0, "whole"),
    }
    for field, (column, default) in component.fields.items():
        if column.shape or column.dtype.kind not in "fiub":
            continue
        if column.dtype.kind in "iu":
            ends = np.iinfo(column.dtype)
            spans[column.dtype.kind] = float(ends.min), float(ends.max), "whole"
        low, high, kind = spans[column.dtype.kind]
        name = f"{component.__name__}.{field}"
        text = " ".join((component.__doc__ or name).partition("\n\n")[0].split())
        yield _trait(name, component.__name__, float(default), text, "own", low, high, kind)
