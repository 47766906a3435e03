"""A species: body, chemistry, sensors, nervous system, reproduction and death."""

from dataclasses import fields
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, ModelWrapValidatorHandler, PrivateAttr, model_validator

from ecs_eco.config.features.building import Building
from ecs_eco.config.features.carrying import Carrying
from ecs_eco.config.features.chemistry import Chemistry, Emitting, Provision
from ecs_eco.config.features.death import Mortality
from ecs_eco.config.features.ectothermy import Ectothermy
from ecs_eco.config.features.eggs import Eggs
from ecs_eco.config.features.feature import assembled, features_of, of_each
from ecs_eco.config.features.feeding import Defending, Feeding
from ecs_eco.config.features.heat import Warmth
from ecs_eco.config.features.life_history import Caring, Growing, Seasons
from ecs_eco.config.features.neural_costs import NeuralCosts
from ecs_eco.config.features.wandering import Wandering
from ecs_eco.config.former import both_names
from ecs_eco.config.models.body import Body
from ecs_eco.config.models.energy import Locomotion, Metabolism
from ecs_eco.config.models.nerves import THINKING, Continuous, Group, Happiness, Neutral, Policy, Reflex
from ecs_eco.config.models.reproduction import AnyReproduction
from ecs_eco.config.models.sensors import AnySensor, Smell, name_sensors
from ecs_eco.config.models.surroundings import BODY, PROPERTY_UNITS, Color
from ecs_eco.config.numbers import values_in
from ecs_eco.genomes.models import GenomeSection
from ecs_eco.inputs.section import (
    ANEW,
    COLUMN,
    FREE,
    MATTER,
    NUMBERS,
    PARENTLESS,
    POPULATION,
    SHAPE,
    SWITCH,
    Count,
    Function,
    Name,
    NonNegative,
    Real,
    Share,
    about,
    quantity,
    table,
)
from ecs_eco.learning.aliases import resolve
from ecs_eco.learning.settings import PPO

# action groups and their members; the members of speed are the gaits
GROUPS: dict[str, tuple[str, ...] | None] = {
    "speed": None,
    "turn": ("left", "none", "right"),
    "climb": ("up", "none", "down"),
    "pitch": (),
    "eat": ("eat",),
    "mate": ("mate",),
}
MOTIONS = ("speed", "turn", "climb", "pitch")  # groups that may be continuous
NO_NUMBERS = ("locomotion.pace", "life.age_max", "reproduction.choice", "reproduction.spread")  # traits
Look = Literal[  # shapes of view/static/body.js
    "beetle",
    "bird",
    "clover",
    "conifer",
    "copepod",
    "deer",
    "doe",
    "fish",
    "goat",
    "insect",
    "krill",
    "rabbit",
    "sheep",
    "shrub",
    "tree",
    "turtle",
    "wolf",
    "worm",
]
OWN = ("energy", "age", "fertility")  # values that organisms have in addition to properties and substances


@assembled
class Species(
    Warmth,
    Ectothermy,
    Chemistry,
    Provision,
    Seasons,
    Growing,
    Defending,
    Emitting,
    Feeding,
    Carrying,
    Building,
    Caring,
    Eggs,
    Mortality,
    Wandering,
    NeuralCosts,
):
    """A species: its organisms are born with these values, except those that genes code for."""

    count: Annotated[int, Field(ge=0, le=50_000_000)] = quantity(
        "organisms at the start", "1", change=NUMBERS, own=POPULATION
    )
    age: Annotated[list[NonNegative], Field(min_length=2, max_length=2)] | None = quantity(
        "minimum and maximum age of founders and immigrants, drawn uniformly; default: all have age 0",
        "s",
        omit=True,
        change=FREE,
        own=PARENTLESS,
    )
    max_count: Count | None = quantity(
        "maximum number of living organisms: free slots go to newborns at random, and all other births are "
        "counted as refused; migrants of an archipelago always enter; default: limited only by memory",
        "1",
        None,
        change=FREE,
        own=POPULATION,
    )
    color: Color = about("color in figures, #rrggbb", "#4477aa", change=FREE)
    look: Look | None = about(
        "shape in the viewer; default: from its name, or else its diet, habitat and size", None, omit=True
    )
    body: Body = about("shape, size, mass, opacity")
    properties: dict[str, Real] = table(
        f"physical properties at birth by name: {PROPERTY_UNITS}", dict, entries=FREE, own=COLUMN
    )
    substances: dict[Name, NonNegative] = table(
        "concentrations at birth by name [mol/L]", dict, entries=FREE, own=MATTER
    )
    sex: Literal["none", "female", "male", "random"] = about("sex at birth", "none", change=FREE)
    fertility: Share = quantity(
        "fertility at birth; with breeding, its maximum", "1", 1.0, change=FREE, own=COLUMN
    )
    metabolism: Metabolism = table("energy budget", Metabolism)
    locomotion: Locomotion | None = about("movement; absent: it does not move", None)
    sensors: Annotated[list[AnySensor], AfterValidator(name_sensors)] = table(
        "its sensors", list, change=SHAPE
    )
    actions: dict[str, Group] = table(
        "group = actions, of which the policy takes one per tick, or { continuous = [min, max] }",
        dict,
        change=SHAPE,
    )
    default_action: dict[str, Neutral] = table(
        "group = action taken without a decision; for a continuous action, its number, by default the one "
        "nearest to 0",
        dict,
        own=True,
        former="neutral",
    )
    always_on: list[str] = table(
        "actions taken without a decision, unless a reflex blocks them", list, former="automatic"
    )
    reflex: Reflex | None = about("the reflex network", None, change=FREE)
    happiness: Happiness | None = about("the happiness network", None, change=FREE)
    policy: Policy = table("the policy network", Policy)
    ppo: dict[str, Any] = table("hyperparameters: fields of ecs_eco.learning.PPO", dict, entries=FREE)
    genome: GenomeSection | None = about(
        "heredity; absent: all are born with the values in this file", None, change=SHAPE
    )
    components: list[Function] = table("module:name of custom components for its organisms", list)
    reproduction: AnyReproduction | None = about(
        "reproduction; absent: it does not reproduce", None, change=ANEW + SWITCH
    )

    _words: tuple[str, ...] = PrivateAttr(default=())  # alternative names for hyperparameters in the file

    @model_validator(mode="wrap")
    @classmethod
    def _fill_ppo(cls, data: object, check: ModelWrapValidatorHandler[Self]) -> Self:
        """Accept common alternative names for hyperparameters, and record them; fill in defaults."""
        if not isinstance(data, dict) or not isinstance(given := data.get("ppo", {}), dict):
            return check(data)
        try:
            words = resolve(given)
        except ValueError:  # given twice, which is reported elsewhere
            words = {}
        policy = data.get("policy")
        thinks = isinstance(policy, dict) and policy.get("kind") in THINKING
        ppo = (ppo_defaults() if thinks else {}) | {words.get(name, name): x for name, x in given.items()}
        made = check(data | {"ppo": ppo} if ppo else data)
        made._words = tuple(words)
        return made

    @model_validator(mode="after")
    def _name_traits(self) -> Self:
        """Replace former key names in traits; complete the names of derived traits."""
        derived = {} if self.genome is None else self.genome.derived
        for coded in (*(self.genome.genes if self.genome else ()), *derived.values()):
            if coded.trait is not None:
                present, *_ = both_names(tuple(coded.trait.split(".")), self, None)
                coded.__dict__["trait"] = ".".join(map(str, present))
        for name, one in derived.items():
            if one.trait is None:
                keys = [*(".".join(key) for number, key, _ in values_in(self) if number.codable), *NO_NUMBERS]
                ends = [key for key in keys if key.rpartition(".")[2] == name]
                one.__dict__["trait"] = ends[0] if len(ends) == 1 else name
        return self

    def channels(self, dims: int) -> tuple[str, ...]:
        """Return the names of the sensory inputs in order, in a space with `dims` axes."""
        return tuple([channel for sensor in self.sensors for channel in sensor.channels(dims)])

    def readings(self, dims: int) -> dict[str, tuple[int, ...]]:
        """Return the names that networks can use, and the channels that each averages."""
        fields: dict[str, tuple[int, ...]] = {}
        named = [(sensor, channel) for sensor in self.sensors for channel in sensor.channels(dims)]
        for row, (sensor, _) in enumerate(named):
            if isinstance(sensor, Smell):
                fields[sensor.field] = (*fields.get(sensor.field, ()), row)
        return fields | {channel: (row,) for row, (_, channel) in enumerate(named)}

    def groups(self) -> dict[str, list[str]]:
        """Return the actions of each group; a continuous group has one, with the name of the group."""
        return {
            group: [group] if isinstance(actions, Continuous) else actions
            for group, actions in self.actions.items()
        }

    def ranges(self) -> dict[str, tuple[float, float]]:
        """Return the minimum and maximum of each continuous action, by group."""
        return {
            group: (actions.continuous[0], actions.continuous[1])
            for group, actions in self.actions.items()
            if isinstance(actions, Continuous)
        }

    def known_groups(self) -> dict[str, tuple[str, list[str]]]:
        """Return, for each group that shipped systems handle, the word for an action and the actions."""
        gaits = list(self.locomotion.speed if self.locomotion else ())
        known = {group: ("action", list(names or ())) for group, names in GROUPS.items()}
        known["speed"] = "gait in locomotion.speed", gaits
        features = features_of(type(self))
        known |= {g: ("action", list(names or ())) for f in features for g, names in f.acts.items()}
        return known | {group: (word, names) for group, word, names in of_each(self, "acting")}

    @property
    def mates(self) -> bool:
        """Whether the genomes of two parents are crossed."""
        sexual = self.reproduction is not None and self.reproduction.kind == "sexual"
        return sexual and self.genome is not None and self.genome.mate.chance > 0

    def action_list(self) -> tuple[tuple[str, str], ...]:
        """Return (group, action) for every action, in the order of the decision vector."""
        return tuple([(group, action) for group, actions in self.groups().items() for action in actions])

    def decisions(self) -> list[tuple[str, str]]:
        """Return (group, action) for every action that needs a decision."""
        always = set(self.always_on)
        return [pair for pair in self.action_list() if always.isdisjoint((pair[1], ".".join(pair)))]

    def action_rows(self) -> dict[str, int]:
        """Return the row in the decision vector by group.action, and by the plain name if it is unique."""
        rows = {pair: row for row, pair in enumerate(self.action_list())}
        plain = [action for _, action in rows]
        full = {f"{group}.{action}": row for (group, action), row in rows.items()}
        return full | {action: row for (_, action), row in rows.items() if plain.count(action) == 1}

    def own(self) -> tuple[str, ...]:
        """Return the names of properties that the species can sense in itself or that can kill it."""
        return (*OWN, *(name for name, _ in of_each(self, "feels")), *self.properties, *self.substances)

    def knows_kin(self) -> bool:
        """Return whether the species' members must know their parents."""
        return self.care is not None or any(getattr(sensor, "kin", None) for sensor in self.sensors)

    def felt(self) -> tuple[str, ...]:
        """Return the names of properties of its bodies that sensors can read, including its own."""
        return tuple(dict.fromkeys((*self.own(), "sex", *BODY)))


def ppo_defaults() -> dict[str, Any]:
    """Return every hyperparameter of PPO with its default."""
    return {f.name: f.default for f in fields(PPO)}
