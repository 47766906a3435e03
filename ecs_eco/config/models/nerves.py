"""The three networks of the nervous system: reflex, happiness and policy (paper, Definition 3)."""

from typing import Annotated, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from ecs_eco.engine.submodel import Submodel
from ecs_eco.inputs.section import (
    COLUMN,
    FREE,
    SHAPE,
    Function,
    Name,
    NonNegative,
    Pair,
    Real,
    Section,
    WithParameters,
    about,
    quantity,
    table,
)


class Continuous(Section, own=True):
    """A numeric action: the policy draws its value from a normal distribution, and reflexes shift it."""

    continuous: Pair = quantity("minimum and maximum of the number", "unit of the group")


THINKING = ("shared", "individual")  # kinds of policies that are neural networks


Group = Annotated[
    Annotated[list[str], Tag("names")] | Annotated[Continuous, Tag("range")],
    Discriminator(lambda value: "range" if isinstance(value, dict | Continuous) else "names"),
]
Neutral = Annotated[
    Annotated[str, Tag("word")] | Annotated[Real, Tag("number")],
    Discriminator(lambda value: "number" if isinstance(value, int | float) else "word"),
]


class Connection(Section, own=COLUMN):
    """A connection in the reflex network: while the reading is beyond the threshold, the weight is added to
    the action."""

    name: Name | None = about("name used by genes and in drawings; default: SENSOR_ACTION", None)
    sensor: str = about("name of a sensor channel")
    action: str = about("name of an action, or group.action")
    weight: Literal[-1, 0, 1] = about(
        "-1 blocks the action, 0 leaves it to the policy, 1 forces it; -1 and 1 move a continuous action to "
        "its minimum and maximum"
    )
    above: Real | None = quantity("active above this reading", "reading", None)
    below: Real | None = quantity("active below this reading", "reading", None)

    @property
    def label(self) -> str:
        """The connection's name, by default SENSOR_ACTION."""
        return self.name or f"{self.sensor}_{self.action.replace('.', '_')}"

    @model_validator(mode="after")
    def _one_threshold(self) -> Self:
        if (self.above is None) == (self.below is None):
            raise ValueError("give exactly one of above and below")
        return self


class Reflex(Section):
    """The reflex network; if it has several forms, their values are added, and only the sign of the sum
    matters."""

    connections: list[Connection] = table("individual connections", list)
    formulas: dict[str, str] = table("action = expression of sensors; the sign of its value counts", dict)
    function: WithParameters | None = about(
        "module:name of a function from sensors (n, channels) to (n, actions)", None
    )


class Happiness(Section):
    """The happiness network: weights, a formula or a function of the sensors. If several sensors smell a
    field, its name is the mean of their channels: `wolf_smell` is the mean of `wolf_smell_1` and
    `wolf_smell_2`."""

    weights: dict[str, Real] = table("sensor = weight in a sum", dict, own=COLUMN)
    formula: str | None = about("expression of sensors", None)
    function: WithParameters | None = about(
        "module:name of a function from sensors (n, channels) to (n)", None
    )
    minimum: Real = quantity("happiness at death: the minimum value of the network", "1", own=True)

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if bool(self.weights) + (self.formula is not None) + (self.function is not None) != 1:
            raise ValueError("give exactly one of weights, formula and function")
        return self


class Policy(Section, change=SHAPE):
    """The policy network, the only network that learns."""

    submodel = Submodel(
        "Learning",
        where=("policy.learn", "policy.file"),
        reads=("ppo",),
        rules={
            "": "The policy learns by PPO (Schulman et al. 2017). After each rollout of `horizon` ticks, "
            "Adam minimizes the mean of `−min(r A, clip(r, 1 − clip, 1 + clip) A) − entropy_coef H + "
            "value_weight (V − R)²`, where r is the ratio of the new to the old probability of the action "
            "taken, H the entropy of the policy, V the predicted value and `R = A + V_old`.",
            "policy": "The advantage is `A(t) = δ(t) + discount × gae_lambda × A(t + 1)`, with "
            "`δ(t) = reward(t + 1) + discount × V(x(t + 1)) − V(x(t))` (Schulman et al. 2016, eq. 16).",
            "policy.kind=shared": "All members contribute to one rollout, including those that die before it is "
            "full.",
            "policy.kind=individual": "Each individual learns from its own rollout; its first rollout ends at a "
            "random age, so that individuals learn in different ticks. An unfinished rollout is lost at death.",
            "policy.kind=individual & policy.inherit=none": "A newborn's network has random weights; learned "
            "weights are lost at death.",
            "policy.inherit=birth": "A newborn's network has the weights in its genome; learned weights are "
            "lost at death.",
            "policy.inherit=learned": "A newborn's network has the current weights of one parent, plus "
            "normal noise with standard deviation `mutation_sd`.",
        },
        draws="initial weights and noise in inherited weights, the order of transitions in minibatches, and the "
        "ages at which individual learners begin",
    )

    kind: Literal["shared", "individual", "external", "function", "none"] = about(
        "shared: one network for the whole species; individual: one network per organism; external: an "
        "outside program decides (world.external, ecs_eco.rl); function: a function decides; none: no policy",
        "none",
    )
    function: WithParameters | None = about(
        "module:name of a function from sensors (n, channels) and uids (n) to choices (n, groups), "
        'for kind = "function"',
        omit=True,
        entries=SHAPE,
    )
    inherit: Literal["none", "birth", "learned"] = about(
        "initial weights of an individual network; none: random; birth: weights in its genome; learned: a "
        "parent's current weights",
        "none",
        change=FREE,
    )
    mutation_sd: NonNegative = quantity(
        "standard deviation of the noise added to each inherited weight",
        "1",
        0.0,
        change=FREE,
        former="mutation",
        own="it is noise in weights inherited outside the genome; genome.mutate sets the mutation of letters",
    )
    network: Function | None = about(
        "module:name of a torch module, created as Net(n_observations, groups); default: built-in network",
        None,
    )
    device: Annotated[str, Field(pattern=r"^(cpu|cuda(:\d{1,3})?)$")] = about(
        "device on which the network infers and learns: cpu, cuda or cuda:N", "cpu"
    )
    hidden: Annotated[list[Annotated[int, Field(ge=1, le=4096)]], Field(max_length=8)] = quantity(
        "units of each hidden layer of the built-in network", "1", [64, 64], own=COLUMN
    )
    learn: bool = about("whether it learns during a run", False, change=FREE)
    file: str | None = about(
        "file of trained weights (.safetensors), relative to the world file",
        None,
        change="World.from_config(…, policies=…)",
    )

    @property
    def thinks(self) -> bool:
        """Whether the policy is a neural network."""
        return self.kind in THINKING
