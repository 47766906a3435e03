"""A species: body, chemistry, senses, nerves, reproduction and death."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Annotated, Any, Literal

from pydantic import Field, PrivateAttr, field_validator, model_validator

from ecs_eco.config.models.body import Body
from ecs_eco.config.models.heat import BodyHeat
from ecs_eco.config.models.life import Breeding, Care, Growth, Hatching
from ecs_eco.config.models.matter import AnyExchange, Emission, Reaction
from ecs_eco.config.models.nerves import THINKING, Continuous, Group, Happiness, Neutral, Policy, Reflex
from ecs_eco.config.models.objects import Build, Carry
from ecs_eco.config.models.reproduction import AnyReproduction
from ecs_eco.config.models.sensors import AnySensor, Smell, name_sensors
from ecs_eco.config.models.surroundings import BODY, PROPERTIES, Color
from ecs_eco.engine.section import (
    Count,
    Function,
    Name,
    NonNegative,
    Positive,
    Real,
    Section,
    Share,
    about,
    is_absent,
    is_empty,
    quantity,
    table,
)
from ecs_eco.genomes.models import GenomeSection
from ecs_eco.learning.words import ours

# groups of actions and their members; those of speed are the gaits
GROUPS: dict[str, tuple[str, ...] | None] = {
    "speed": None,
    "turn": ("left", "none", "right"),
    "climb": ("up", "none", "down"),
    "pitch": (),
    "eat": ("eat",),
    "mate": ("mate",),
    "nurse": ("nurse",),
    "carry": ("take", "none", "drop"),
    "build": None,
}
MOTIONS = ("speed", "turn", "climb", "pitch")  # that may be continuous
OWN = ("energy", "age", "fertility")  # values of every organism besides its properties and substances


class Metabolism(Section):
    """The energy budget of one organism; the unit of energy is the world's own."""

    energy: NonNegative = quantity("energy at the start and of a newborn without parent", "energy", 1.0)
    energy_spread: Share | None = quantity(
        "founders and immigrants have 1 − energy_spread to 1 + energy_spread times that energy, drawn evenly "
        "and at most energy_max; 0: all have the same; absent: 0.25 for a species with a nervous system, so "
        "that not all starve at once, 0 for others", "1", None, exclude_if=is_absent)
    energy_max: Positive = quantity("most energy that an organism can hold", "energy", 1.0)
    basal: NonNegative = quantity("energy burnt by living", "energy/s", 0.0)
    growth: NonNegative = quantity("energy made in full light", "energy/s", 0.0)
    digestion: NonNegative = quantity("time after a meal without another", "s", 0.0)
    torpor: bool = about("whether it falls into torpor where no energy is left: it burns nothing, stands "
                         "still and does not mate until it has eaten or grown; else energy falls below 0, "
                         "and `lethal` says what that means", False, exclude_if=is_absent)


class Locomotion(Section):
    """Gaits, their costs, and how fast it turns."""

    speed: dict[Name, NonNegative] = quantity("speed of each gait", "m/s", min_length=1)
    cost: dict[Name, NonNegative] = quantity("energy burnt in each gait", "energy/s", {})
    turn: NonNegative = quantity("rate of turning", "rad/s", 0.0)
    climb: NonNegative = quantity("speed up and down in a volume, the same in all gaits", "m/s", 0.0)
    pitch: Annotated[float, Field(ge=0, le=math.pi / 2)] = quantity(
        "angle by which it swims up or down in a volume, at the speed of its gait; instead of climb", "rad",
        0.0
    )
    drag: NonNegative = quantity("rate at which speed approaches that of the gait, by drag; 0: at once",
                                 "1/s", 0.0)


class Diet(Section):
    """One kind of food."""

    eats: str = about("a species or an object type")
    reach: NonNegative = quantity("distance between the surfaces of both bodies", "m", 0.0)
    chance: Share = quantity("chance of success in one second of contact", "1", 1.0)
    gain: Real = quantity("energy gained from each, whatever it holds", "energy", 0.0)
    efficiency: Share = quantity("share of the energy held by the eaten that is gained in addition", "1", 0.0)
    deadly: bool = about("whether its poison kills the eater", False)
    until: Real | None = quantity("eats only below this energy; absent: while it is not full", "energy", None)
    assimilation: Share | None = quantity(
        "share of the eaten's substances that its body keeps, where both hold substances; the rest goes to "
        "the first field of each, or is lost; absent: all of it", "1", None, exclude_if=is_absent)


class Defence(Section):
    """Defence against being eaten, and its cost."""

    toughness: Share = quantity("share of the bites into it that fail", "1", 0.0)
    poison: NonNegative = quantity("energy that its eater loses", "energy", 0.0)
    cost: NonNegative = quantity(
        "share of growth and of sprouting seeds lost per unit of toughness and of poison", "1", 0.0
    )


class Lethal(Section):
    """The interval of one property outside of which the organism dies."""

    property: str = about("energy, age, fertility, a property or substance that the species has, or "
                          "Component.field of a component of your own")
    min: Real | None = quantity("dies at or below", "unit of the property", None)
    max: Real | None = quantity("dies at or above", "unit of the property", None)
    low: Annotated[str, Field(max_length=60)] = about("cause of death below min", "")
    high: Annotated[str, Field(max_length=60)] = about("cause of death above max", "")

    @model_validator(mode="before")
    @classmethod
    def _name_causes(cls, data: Any) -> Any:
        if isinstance(data, dict) and isinstance(data.get("property"), str):
            words = {"low": ("min", "too low"), "high": ("max", "too high")}
            named = {w: f"{data['property']} {text}"
                     for w, (end, text) in words.items() if data.get(end) is not None}
            return named | {k: v for k, v in data.items() if not (k in named and v == "")}
        return data


class Species(Section):
    """One species: all its organisms are born with these values."""

    count: Annotated[int, Field(ge=0, le=50_000_000)] = quantity("organisms at the start", "1")
    age: Annotated[list[NonNegative], Field(min_length=2, max_length=2)] | None = quantity(
        "least and most age of founders and of immigrants, drawn evenly between them; absent: all are of "
        "age 0", "s", None, exclude_if=is_absent)
    max_count: Count | None = quantity(
        "most that may live at once: those to be born share the free places at random, others are counted "
        "as refused; migrants of an archipelago always come in; absent: no limit but memory", "1", None)
    color: Color = about("colour in figures, #rrggbb", "#4477aa")
    body: Body = about("shape, size, mass, opacity")
    properties: dict[str, Real] = table(f"physical properties at birth by name: {', '.join(PROPERTIES)}",
                                        dict)
    heat: BodyHeat | None = about("how its temperature changes; absent: it stays as it was at birth", None,
                                  exclude_if=is_absent)
    substances: dict[Name, NonNegative] = table("concentrations at birth by name [mol/L]", dict)
    reactions: list[Reaction] = about("what its metabolism makes of its substances, in this order", [],
                                      exclude_if=is_absent)
    exchange: list[AnyExchange] = about("what it takes up from fields and gives off, in this order",
                                        [], exclude_if=is_absent)
    born_with: Literal["declared", "mother", "soil"] = about(
        "where the substances of newborn come from: declared: from nowhere; mother: she shares what she "
        "holds, at equal concentration; soil: from the first field of each, where a seed falls, and it "
        "sprouts only where there is enough", "declared", exclude_if=lambda value: value == "declared")
    sex: Literal["none", "female", "male", "random"] = about("sex at birth", "none")
    fertility: Share = quantity("fertility at birth; with breeding, its height", "1", 1.0)
    breeding: Breeding | None = about("how fertility depends on age and season; absent: it stays", None,
                                      exclude_if=is_absent)
    growth: Growth | None = about("how the young grow; absent: they are born as large as adults", None,
                                  exclude_if=is_absent)
    metabolism: Metabolism = table("energy budget", Metabolism)
    locomotion: Locomotion | None = about("how it moves; absent: it does not", None)
    defence: Defence = table("defence against being eaten", Defence)
    emits: dict[Name, NonNegative | Emission] = table(
        "field = amount put into it [1/s], or { substance, rate, consume }", dict)
    diet: list[Diet] = table("what it eats", list)
    carries: list[Carry] = about("what it can pick up and put down", [], exclude_if=is_empty)
    builds: list[Build] = about("what it can make", [], exclude_if=is_empty)
    sensors: list[AnySensor] = table("what it senses", list)
    actions: dict[str, Group] = table("group = actions, of which the policy takes one at a time, "
                                      "or { continuous = [least, most] }", dict)
    neutral: dict[str, Neutral] = table("group = action taken if none is decided; of a continuous one: "
                                        "the number, else that nearest to 0", dict)
    automatic: list[str] = table("actions that need no decision: always on unless a reflex blocks them", list)
    reflex: Reflex | None = about("the reflex network", None)
    happiness: Happiness | None = about("the happiness network", None)
    policy: Policy = table("the policy network", Policy)
    ppo: dict[str, Any] = table("hyperparameters: fields of ecs_eco.learning.PPO", dict)
    genome: GenomeSection | None = about("heredity; absent: all are born with these values", None)
    components: list[Function] = table("module:name of components of your own for its organisms", list)
    reproduction: AnyReproduction | None = about("how it multiplies; absent: it does not", None)
    care: Care | None = about("how parents feed their young; absent: they do not", None,
                              exclude_if=is_absent)
    hatch: Hatching | None = about("these are eggs: who hatches from them, and when; absent: they are not",
                                   None, exclude_if=is_absent)
    lethal: list[Lethal] = table("what kills it besides being eaten", list)
    remains: str | None = about("object type that the dead leave", None)

    _words: tuple[str, ...] = PrivateAttr(default=())  # of others, for hyperparameters

    @field_validator("sensors")
    @classmethod
    def _name(cls, sensors: list[Any]) -> list[Any]:
        return name_sensors(sensors)

    @model_validator(mode="wrap")
    @classmethod
    def _rename_ppo(cls, data: Any, check: Any) -> Any:
        """Take the words of others for hyperparameters, and note them."""
        given = data.get("ppo") if isinstance(data, dict) else None
        if not isinstance(given, dict) or not (words := _ours(given)):
            return check(data)
        made = check(data | {"ppo": {words.get(name, name): value for name, value in given.items()}})
        made._words = tuple(words)
        return made

    @model_validator(mode="before")
    @classmethod
    def _fill_ppo(cls, data: Any) -> Any:
        if (isinstance(data, dict) and isinstance(data.get("policy"), dict)
            and data["policy"].get("kind") in THINKING):
            given = data.get("ppo", {})
            return data | {"ppo": ppo_defaults() | given} if isinstance(given, dict) else data
        return data

    def channels(self, dims: int) -> tuple[str, ...]:
        """Names of the sensory inputs in their order, in a space of `dims` axes."""
        return tuple(c for sensor in self.sensors for c in sensor.channels(dims))

    def readings(self, dims: int) -> dict[str, tuple[int, ...]]:
        """Names that formulas, weights and reflexes may use, and the channels that each averages."""
        names: dict[str, tuple[int, ...]] = {}
        for row, sensor in enumerate(self._sensor_of_channel(dims)):
            if isinstance(sensor, Smell):
                names[sensor.field] = (*names.get(sensor.field, ()), row)
        return names | {channel: (row,) for row, channel in enumerate(self.channels(dims))}

    def groups(self) -> dict[str, list[str]]:
        """The names of the actions of each group; a continuous one is a single action, named as its group."""
        return {group: [group] if isinstance(actions, Continuous) else actions
                for group, actions in self.actions.items()}

    def ranges(self) -> dict[str, tuple[float, float]]:
        """Least and most of each continuous action, by its group."""
        return {group: (actions.continuous[0], actions.continuous[1])
                for group, actions in self.actions.items() if isinstance(actions, Continuous)}

    @property
    def mates(self) -> bool:
        """Whether genomes of two parents are crossed."""
        sexual = self.reproduction is not None and self.reproduction.kind == "sexual"
        return sexual and self.genome is not None and self.genome.mate.chance > 0

    def action_list(self) -> tuple[tuple[str, str], ...]:
        """(group, action) of every action in the order of the decision vector."""
        return tuple((group, action) for group, actions in self.groups().items() for action in actions)

    def action_rows(self) -> dict[str, int]:
        """Row in the decision vector by group.action, and by the plain name if only one group has it."""
        rows = {pair: row for row, pair in enumerate(self.action_list())}
        plain = [action for _, action in rows]
        full = {f"{group}.{action}": row for (group, action), row in rows.items()}
        return full | {action: row for (_, action), row in rows.items() if plain.count(action) == 1}

    def own(self) -> tuple[str, ...]:
        """Names of properties that the species can sense in itself or die of."""
        return (*OWN, *(("load",) if self.carries else ()), *self.properties, *self.substances)

    def knows_kin(self) -> bool:
        """Whether its members must know whose children they are."""
        return self.care is not None or any(getattr(sensor, "kin", None) for sensor in self.sensors)

    def felt(self) -> tuple[str, ...]:
        """Names of properties that the species can sense in itself, and others in its bodies."""
        return tuple(dict.fromkeys((*self.own(), "sex", *BODY)))

    def _sensor_of_channel(self, dims: int) -> list[Any]:
        return [sensor for sensor in self.sensors for _ in sensor.channels(dims)]


def _ours(given: dict[str, Any]) -> dict[str, str]:
    """Our names of the words of others for hyperparameters; none where one is given twice, which checks say.
    """
    try:
        return ours(given)
    except ValueError:
        return {}


def ppo_defaults() -> dict[str, Any]:
    """Every hyperparameter of PPO with its default."""
    from ecs_eco.learning import PPO  # not at the top: listing species must not load learning

    return {f.name: f.default for f in fields(PPO)}
