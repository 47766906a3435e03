"""Treatments: what an arm of a comparison changes in a world. One table holds all named ones.

A treatment may change values of the configuration (`changes.py`), the initial policies, whether they learn,
or the species as a world is built (`ecs_eco.life.treatments`). On the command line they are `--control`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from ecs_eco.config import WorldConfig, load
from ecs_eco.engine.errors import ConfigError, Problem, nearest
from ecs_eco.experiments import changes
from ecs_eco.experiments.changes import NotApplicable

OPTION = "--control"  # where treatments are named, as errors say
ABSENT = "no-"  # followed by the name of a species: without that species


def anywhere(config: WorldConfig) -> None:
    """Accept any world."""


def needs_policy(config: WorldConfig) -> None:
    """Raise NotApplicable where no species has a policy."""
    if not species_with_policy(config):
        raise NotApplicable("no species has a policy", "a changed value: key=value")


def needs_reflex(config: WorldConfig) -> None:
    """Raise NotApplicable where no species has a reflex."""
    if all(s.reflex is None for s in config.species.values()):
        raise NotApplicable("no species has a reflex", "a treatment that removes something")


def needs_genome(config: WorldConfig) -> None:
    """Raise NotApplicable where nothing is inherited: neither a genome nor learned weights."""
    if all(s.genome is None and s.policy.inherit != "learned" for s in config.species.values()):
        raise NotApplicable("no species has a genome", "a treatment that removes something")


@dataclass(frozen=True)
class Treatment:
    """What one arm of a comparison changes."""

    name: str  # as --control takes it
    summary: str
    changes: Callable[[WorldConfig], dict[str, Any]] | None = None  # values by dotted key
    assignment: str = ""  # KEY=VALUE, if it changes nothing else
    policies: Any = "trained"  # or a word for all species, or a dict: species → word
    learn: bool | None = None  # whether policies learn in the run; None: as the world says
    at_build: bool = False  # whether it is one of `ecs_eco.life.treatments`
    needs_learning: bool = False  # whether a run in which nothing learns is the same with and without it
    check: Callable[[WorldConfig], None] = anywhere  # raises NotApplicable

    @property
    def changes_config(self) -> bool:
        """Whether it makes another configuration, in which policies can be trained."""
        return self.changes is not None or bool(self.assignment)

    def apply_to(self, config: WorldConfig) -> WorldConfig:
        """Return the configuration under this treatment. Raises NotApplicable, ConfigError."""
        self.check(config)
        if self.assignment:
            return load(config, [self.assignment])
        return config if self.changes is None else load(config, self.changes(config))


_TREATMENTS = (
    Treatment("random-policy", "actions are drawn at random", policies="random", check=needs_policy),
    Treatment("untrained-policy", "networks start from random weights", policies="untrained"),
    Treatment("learning", "policies keep learning in the run", learn=True),
    Treatment("frozen-learning", "policies stay as they were trained", learn=False),
    Treatment("no-reflexes", "there are no reflexes", at_build=True, check=needs_reflex),
    Treatment("neutral-drift", "genes are inherited and not expressed", at_build=True, check=needs_genome),
    Treatment("shuffled-genome", "genes come from any of the living", at_build=True, check=needs_genome),
    Treatment("no-mutation", "nothing mutates", at_build=True, check=needs_genome),
    Treatment("constant-light", "light is the mean of the day", changes.constant_light),
    Treatment("inverted-light", "the day is dark", changes.inverted_light),
    Treatment("no-smell", "nobody smells anything", changes.no_smell),
    Treatment("energy-only", "happiness is energy alone", changes.energy_only, needs_learning=True),
    Treatment("energy-and-light", "light makes unhappy", changes.energy_and_light, needs_learning=True),
)
TREATMENTS: dict[str, Treatment] = {treatment.name: treatment for treatment in _TREATMENTS}
FOR_ONE_SPECIES = ("random-policy", "untrained-policy")  # as random-policy:deer


def names(config: WorldConfig) -> list[str]:
    """Return the names of all treatments, whether or not this world has something for them."""
    return [*TREATMENTS, *(ABSENT + species for species in config.species)]


def find(name: str, config: WorldConfig) -> Treatment:
    """Return the treatment of this name, or KEY=VALUE. Raises ConfigError with the nearest name."""
    kind, _, species = name.partition(":")
    one = TREATMENTS[kind] if kind in FOR_ONE_SPECIES else None
    if one is not None and species in species_with_policy(config):
        return replace(one, name=name, summary=f"{species}: {one.summary}", policies={species: one.policies})
    if name in TREATMENTS:
        return TREATMENTS[name]
    if name in names(config):
        absent = name.removeprefix(ABSENT)
        return Treatment(name, f"there is no {absent}", partial(changes.without, species=absent))
    if "=" in name:
        return Treatment(name, name, assignment=name)
    if one is not None:
        known = species_with_policy(config)
        allowed = ", ".join(known) or "none"
        raise refusal("no such species with a policy", species, allowed, nearest(species, known))
    allowed = (
        f"{', '.join(names(config))}, one of the first two for a single species (random-policy:NAME), "
        "or a value: key=value"
    )
    raise refusal("no such treatment", name, allowed, nearest(name, names(config)))


def species_with_policy(config: WorldConfig) -> list[str]:
    """Return the names of the species that have a policy network."""
    return [name for name, species in config.species.items() if species.policy.thinks]


def refusal(fault: str, value: object, allowed: str, near: str = "", source: str = OPTION) -> ConfigError:
    """Return the error for an option of a comparison that is refused."""
    return ConfigError([Problem((), fault, value, allowed, near, source)])
