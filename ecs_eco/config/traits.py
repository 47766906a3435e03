"""Which values of a species can be heritable, and the columns that hold an organism's own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from typing import Any

import numpy as np

from ecs_eco.config.models.nerves import Connection
from ecs_eco.config.models.species import Species, ppo_defaults
from ecs_eco.config.models.surroundings import PROPERTIES
from ecs_eco.config.numbers import PLACE, Number, numbers_of, values_in
from ecs_eco.engine.section import COLUMN, LARGEST, SMALLEST
from ecs_eco.genomes.choices import CHOICES
from ecs_eco.genomes.traits import Kind, Trait

TINY = 1e-6  # the least value of traits that must be above 0


def traits_of(species: Species, dims: int, extra_components: Iterable[Any] = ()) -> dict[str, Trait]:
    """Return every trait that this species could make heritable, by name, in a space of `dims` axes.

    `extra_components` are components of the user's own: each number of theirs is the trait Component.field.
    Of the traits in Traits those that a gene of the species codes for have an index.
    """
    traits = [
        *_of_body(species),
        *_of_state(species),
        *_of_sensors(species),
        *_of_nerves(species),
        *_of_instincts(species),
        *_of_learning(species),
        *_of_breeding(species),
        *_of_life(species),
        *_of_section(species),
        *_of_organs(species),
    ]
    for component in extra_components:
        traits += _of_component(component)
    in_traits = {trait.name for trait in traits if trait.component == "Traits"}
    section = species.genome
    coded = [] if section is None else [gene.trait for gene in section.genes]
    coded += [] if section is None else [derived.trait for derived in section.derived.values()]
    places = [trait for trait in coded if trait in in_traits]  # their order stays, whatever changes
    return {
        trait.name: replace(trait, index=places.index(trait.name))
        if trait.component == "Traits" and trait.name in places
        else trait
        for trait in traits
    }


def numbers_of_species(model: type[Species] = Species) -> dict[str, Number]:
    """Every number that a species' section may hold, hyperparameters too, by its pattern."""
    from ecs_eco.learning import PPO

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
    """Return why no organism has its own value of a key of its species; "" where it can, or where there is no
    such number."""
    parts = key.split(".")
    for number in numbers_of_species(model).values():
        fits = len(number.pattern) == len(parts) and all(
            a in (PLACE, b) for a, b in zip(number.pattern, parts, strict=True)
        )
        if fits and isinstance(number.own, str) and number.own != COLUMN:
            return number.own
    return ""


def label_of(connection: Connection) -> str:
    """The name of a reflex connection for genes: its own, or SENSOR_ACTION."""
    return connection.name or f"{connection.sensor}_{connection.action}"


def _of_body(species: Species) -> Iterator[Trait]:
    body, moves, metabolism = species.body, species.locomotion, species.metabolism
    owner = "Body" if species.growth is None else "Stature"
    yield Trait(
        "body.radius", owner, "radius", None, body.radius, TINY, LARGEST, "number", "m", "radius of the body"
    )
    yield Trait(
        "body.mass", owner, "mass", None, body.mass, TINY, LARGEST, "number", "kg", "mass of the body"
    )
    if moves is not None:
        text = "factor of all its speeds; the cost of moving grows with its square"
        yield Trait("locomotion.pace", "Vigour", "pace", None, 1.0, 0.0, LARGEST, "number", "1", text)
    text = "energy made in full light"
    yield Trait(
        "metabolism.growth",
        "Growth",
        "growth",
        None,
        metabolism.growth,
        0.0,
        LARGEST,
        "number",
        "energy/s",
        text,
    )
    if species.heat is not None:
        text = "insulation of its fur, feathers or fat"
        yield Trait(
            "heat.insulation",
            "Coat",
            "insulation",
            None,
            species.heat.insulation,
            0.0,
            LARGEST,
            "number",
            "K m^2/W",
            text,
        )
    defence = species.defence
    text = "share of the bites into it that fail"
    yield Trait(
        "defence.toughness", "Defence", "toughness", None, defence.toughness, 0.0, 1.0, "number", "1", text
    )
    text = "energy that its eater loses"
    yield Trait(
        "defence.poison", "Defence", "poison", None, defence.poison, 0.0, LARGEST, "number", "energy", text
    )


def _of_state(species: Species) -> Iterator[Trait]:
    """What an organism is born with, and what may change in its life."""
    for name, value in species.properties.items():
        yield Trait(
            f"properties.{name}",
            "Physical",
            name,
            None,
            value,
            -LARGEST,
            LARGEST,
            "number",
            PROPERTIES.get(name, "1"),
            f"{name.replace('_', ' ')} at birth",
        )


def _of_section(species: Species) -> Iterator[Trait]:
    """The numbers of its section that are kept in Traits."""
    for number, key, value in values_in(species):
        name = ".".join(key)
        if number.own is not True or name == "lethal.age.max":
            continue
        low = SMALLEST if number.above and number.low == 0 else number.low
        yield Trait(
            name,
            "Traits",
            "value",
            None,
            value,
            low,
            number.high,
            "whole" if number.whole else "number",
            number.unit,
            number.text,
        )


def _of_sensors(species: Species) -> Iterator[Trait]:
    for i, sensor in enumerate(species.sensors):
        if (radius := getattr(sensor, "radius", None)) is not None:
            text = f"how far the sensor {sensor.name} reaches"
            yield Trait(
                f"sensors.{sensor.name}.radius",
                "Senses",
                "radius",
                i,
                radius,
                TINY,
                LARGEST,
                "number",
                "m",
                text,
            )
        if (at := getattr(sensor, "at", None)) is None or sensor.kind in ("touch", "own"):
            continue  # of the own body only the height of the place counts, and that is no gene
        for axis, way in enumerate(("forward", "left")):
            text = f"where on the body the sensor {sensor.name} is, {way}, in radii of the body"
            yield Trait(
                f"sensors.{sensor.name}.{way}",
                "Senses",
                way,
                i,
                at[axis],
                -LARGEST,
                LARGEST,
                "number",
                "1",
                text,
            )


def _of_nerves(species: Species) -> Iterator[Trait]:
    for i, c in enumerate(species.reflex.connections if species.reflex else ()):
        name, way = label_of(c), "above" if c.above is not None else "below"
        threshold = c.above if c.above is not None else c.below
        text = (
            f"while {c.sensor} is {way} the threshold: −1 blocks {c.action}, 0 leaves it to the policy, "
            "1 forces it"
        )
        yield Trait(f"reflex.{name}.weight", "Reflexes", "weight", i, c.weight, -1.0, 1.0, "sign", "1", text)
        text = f"{c.action} answers to {c.sensor} {way} this reading"
        own = float(threshold or 0.0)
        yield Trait(
            f"reflex.{name}.threshold",
            "Reflexes",
            "threshold",
            i,
            own,
            -LARGEST,
            LARGEST,
            "number",
            "reading",
            text,
        )
    for i, (channel, weight) in enumerate(species.happiness.weights.items() if species.happiness else ()):
        text = f"what {channel} adds to happiness"
        yield Trait(
            f"happiness.{channel}", "Desires", "weight", i, weight, -LARGEST, LARGEST, "number", "1", text
        )


def _of_instincts(species: Species) -> Iterator[Trait]:
    """The weights of networks that evolution alone changes: functions that `fit_network` made."""
    for word in ("reflex", "happiness"):
        if getattr(getattr(species, word), "function", None) is not None:
            yield Trait(
                f"{word}.weights",
                "Instincts",
                word,
                None,
                0.0,
                -LARGEST,
                LARGEST,
                "weights",
                "1",
                f"weights of its {word} network, where the function is one of fit_network",
            )


def _of_learning(species: Species) -> Iterator[Trait]:
    if species.policy.kind != "individual":
        return
    text = "weights of the policy network at birth"
    yield Trait("policy.weights", "Policy", "weights", None, 0.0, -LARGEST, LARGEST, "weights", "1", text)
    settings = ppo_defaults() | species.ppo
    for field, high in {"learning_rate": LARGEST, "discount": 1.0, "entropy": LARGEST}.items():
        text = f"{field.replace('_', ' ')} of its learning by PPO"
        # anything else is reported elsewhere
        own = float(settings[field]) if isinstance(settings[field], int | float) else 0.0
        yield Trait(f"ppo.{field}", "Plasticity", field, None, own, 0.0, high, "number", "1", text)
    if species.policy.network is not None or species.ranges():
        return  # torch learns with the species' own
    for name, number in numbers_of_species().items():
        value = settings.get(name.removeprefix("ppo."))
        if name.startswith("ppo.") and number.own is True and isinstance(value, int | float):
            low = SMALLEST if number.above else number.low
            yield Trait(
                name,
                "Traits",
                "value",
                None,
                float(value),
                low,
                number.high,
                "whole" if number.whole else "number",
                "1",
                number.text,
            )


def _of_breeding(species: Species) -> Iterator[Trait]:
    way = species.breeding
    if way is None:
        if getattr(species.reproduction, "kind", "spread") == "spread":
            return  # nothing asks for it
        yield Trait(
            "fertility",
            "Biology",
            "fertility",
            None,
            species.fertility,
            0.0,
            1.0,
            "number",
            "1",
            "its fertility",
        )
        return
    values = {
        "maturity": (way.maturity, LARGEST, "s", "age from which it is fertile"),
        "prime": (way.age_of_prime(), LARGEST, "s", "age at which it is most fertile"),
        "end": (LARGEST if way.end is None else way.end, LARGEST, "s", "age at which fertility ends"),
    }
    if way.season is not None:
        text = "length of its season: standard deviation, as a share of a year"
        values |= {
            "season": (way.season, 1.0, "1", "time of the year when it is most fertile"),
            "width": (way.width, 1.0, "1", text),
        }
    yield Trait(
        "fertility",
        "Breeding",
        "peak",
        None,
        species.fertility,
        0.0,
        1.0,
        "number",
        "1",
        "height of its fertility",
    )
    for field, (own, high, unit, text) in values.items():
        yield Trait(f"breeding.{field}", "Breeding", field, None, own, 0.0, high, "number", unit, text)


def _of_life(species: Species) -> Iterator[Trait]:
    age = next((x.max for x in species.lethal if x.property == "age" and x.max is not None), None)
    if age is not None:
        yield Trait(
            "life.age_max",
            "LifeHistory",
            "age_max",
            None,
            age,
            TINY,
            LARGEST,
            "number",
            "s",
            "age at which it dies",
        )
    way = species.reproduction
    if way is not None and way.kind == "spread":
        yield Trait(
            "reproduction.spread",
            "Growth",
            "spread",
            None,
            1.0,
            0.0,
            1.0,
            "number",
            "1",
            "share of its seeds that sprout",
        )
    fields: dict[str, tuple[float, float, Kind, str, str]] = {
        "age_min": (0.0, LARGEST, "number", "s", "least age to reproduce"),
        "energy_min": (0.0, LARGEST, "number", "energy", "least energy to reproduce"),
        "energy_given": (0.0, LARGEST, "number", "energy", "energy of each of its newborn"),
        "litter": (1.0, 10_000.0, "whole", "1", "newborn at a time"),
        "choice": (
            0.0,
            3.0,
            "whole",
            "1",
            "whom it mates with: 0 the nearest, 1 any, 2 the richest, 3 the oldest",
        ),
    }
    for field, (low, high, kind, unit, text) in fields.items():
        value = getattr(way, field, None)
        if value is not None:
            own = float(CHOICES.index(value) if field == "choice" else value)
            yield Trait(f"reproduction.{field}", "LifeHistory", field, None, own, low, high, kind, unit, text)


def _of_organs(species: Species) -> Iterator[Trait]:
    """Which of its sensors, actions and hidden units an organism has."""
    switches = {
        f"sensors.{s.name}.present": f"whether it has the sensor {s.name}; without, it reads 0"
        for s in species.sensors
    }
    switches |= {
        f"actions.{group}.{action}.present": f"whether it can do {action}; without, it never does"
        for group, action in species.action_list()
    }
    for name, text in switches.items():
        yield Trait(name, "Traits", "value", None, 1.0, 0.0, 1.0, "whole", "1", text)
    if species.policy.kind == "individual" and species.policy.network is None and not species.ranges():
        for i, units in enumerate(species.policy.hidden):
            yield Trait(
                f"policy.hidden.{i}",
                "Traits",
                "value",
                None,
                units,
                1.0,
                units,
                "whole",
                "1",
                f"units of the hidden layer {i} that its policy network has",
            )


def _of_component(component: Any) -> Iterator[Trait]:
    for field, (column, default) in component.fields.items():
        if column.shape or column.dtype.kind not in "fiub":
            continue
        low, high, kind = -LARGEST, LARGEST, "number"
        if column.dtype.kind in "iu":
            low, high, kind = float(np.iinfo(column.dtype).min), float(np.iinfo(column.dtype).max), "whole"
        elif column.dtype.kind == "b":
            low, high, kind = 0.0, 1.0, "whole"
        name = f"{component.__name__}.{field}"
        text = " ".join((component.__doc__ or name).partition("\n\n")[0].split())
        yield Trait(name, component.__name__, field, None, float(default), low, high, kind, "own", text)  # type: ignore[arg-type]
