"""Treatments, and the arms of a comparison: the unchanged world and the world under each treatment, with their
policies. A treatment, selected with `--treatment`, can change values of the configuration (by dotted key), the
initial policies, whether they learn, or the species when a world is built (`ecs_eco.life.treatments`).
"""

import hashlib
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, Self, TypeAlias

from ecs_eco.config import WorldConfig, load
from ecs_eco.config.loading import WorldSource
from ecs_eco.config.models.sensors import Gradient, Light, Smell
from ecs_eco.config.models.species import Species
from ecs_eco.engine.errors import ConfigError, Problem, nearest, refusal
from ecs_eco.worlds.policies import POLICIES

LIGHT_WEIGHT = 0.3  # weight of light in the happiness of `energy-and-light`
ANOSMIC = 1e30  # half-saturation that makes a nose read 0


class NotApplicable(ValueError):
    """Raised if a treatment does not apply to this world; `what` is the reason, `allowed` the expected value."""

    def __init__(self, fault: str, allowed: str) -> None:
        self.what, self.allowed = fault, allowed
        super().__init__(f"{fault}; {allowed}")


def _applicable(values: dict[str, Any], fault: str, allowed: str) -> dict[str, Any]:
    """Return a treatment's values. Raises NotApplicable if there are none."""
    if not values:
        raise NotApplicable(fault, allowed)
    return values


def no_smell(config: WorldConfig) -> dict[str, Any]:
    """Disable the sense of smell; smells stay in the world, and networks keep their inputs."""
    values = {
        f"species.{name}.sensors.{i}.{'half_saturation' if sensor.kind == 'smell' else 'scale'}": ANOSMIC
        for name, species in config.species.items()
        for i, sensor in enumerate(species.sensors)
        if isinstance(sensor, Smell | Gradient)
    }
    return _applicable(values, "no species has a nose", 'a world with a sensor of kind "smell" or "gradient"')


def energy_only(config: WorldConfig) -> dict[str, Any]:
    """Replace happiness formulas that depend on light with energy alone."""
    values = {
        f"species.{name}.happiness.formula": energy
        for name, species in config.species.items()
        if _depends_on_light(species) and (energy := _energy(species))
    }
    allowed = "energy-and-light, or a happiness.formula that names energy and light"
    return _applicable(values, "no species has a happiness.formula that depends on light", allowed)


def energy_and_light(config: WorldConfig) -> dict[str, Any]:
    """Make species that sense light dislike it: subtract 0.3 × light from formulas without light."""
    values = {
        f"species.{name}.happiness.formula": f"{_formula(species)} - {LIGHT_WEIGHT} * {light}"
        for name, species in config.species.items()
        if (light := _light(species)) and _formula(species) and not _depends_on_light(species)
    }
    return _applicable(
        values, "no species that senses light has a happiness.formula without it", "energy-only"
    )


def individual_brains(config: WorldConfig) -> dict[str, Any]:
    """Give each animal its own network, with which it learns; newborns start with a parent's current weights."""
    values = {
        f"species.{name}.policy.{key}": value
        for name, species in config.species.items()
        for key, value in (("kind", "individual"), ("inherit", "learned"))
        if species.policy.kind == "shared"
    }
    return _applicable(values, "no species shares a policy", 'a world with policy.kind = "shared"')


def without(config: WorldConfig, species: str) -> dict[str, Any]:
    """Remove a species from runs and from training."""
    if species not in config.species:
        raise NotApplicable(f"no species named {species}", ", ".join(config.species))
    key = f"species.{species}.count"
    out: dict[str, Any] = {key: 0}
    if getattr(config.species[species].reproduction, "immigration", 0.0):
        out[f"species.{species}.reproduction.immigration"] = 0.0
    if key in config.training.vary:
        raise NotApplicable(f"training.vary varies {key}", "a world that does not vary it")
    return out | ({f'training.set."{key}"': 0} if key in config.training.set else {})


def _sun(config: WorldConfig, kind: str) -> dict[str, Any]:
    """Set light to its daily mean at all times, or shift sunrise by half a day."""
    if config.sun is None:
        raise NotApplicable("there is no sun", "a world with [sun]")
    if config.sun.kind == kind:
        raise NotApplicable(f"the sun is {kind} already", "a world with another sun.kind")
    return {"sun.kind": kind}


def _light(species: Species) -> str | None:
    """Return the channel by which a species senses light."""
    return next((s.name or s.base() for s in species.sensors if isinstance(s, Light)), None)


def _energy(species: Species) -> str | None:
    """Return the channel by which a species senses its energy."""
    return next((s.name for s in species.sensors if s.kind == "own" and s.property == "energy"), None)


def _formula(species: Species) -> str:
    """Return a species' happiness formula, in parentheses unless it is a single name; "" without one."""
    text = (species.happiness and species.happiness.formula) or ""
    return text if text.isidentifier() or not text else f"({text})"


def _depends_on_light(species: Species) -> bool:
    light = _light(species)
    return bool(light and re.search(rf"\b{re.escape(light)}\b", _formula(species)))


Policies: TypeAlias = str | dict[str, str]  # a name or folder, for all species or by species
OPTION = "--treatment"  # the option that sets treatments, for error messages
ABSENT = "no-"  # followed by a species' name: the world without that species


def _require(config: WorldConfig, what: str) -> None:
    """Raise NotApplicable if no species has a policy, a reflex, or a genome or inherited weights."""
    species = config.species.values()
    owners = {
        "policy": [s for s in species if s.policy.thinks],
        "reflex": [s for s in species if s.reflex is not None],
        "genome": [s for s in species if s.genome is not None or s.policy.inherit == "learned"],
    }
    if not owners[what]:
        allowed = "a changed value: key=value" if what == "policy" else "a treatment that removes something"
        raise NotApplicable(f"no species has a {what}", allowed)


@dataclass(frozen=True)
class Treatment:
    """The changes in one arm of a comparison."""

    name: str  # as passed to --treatment
    summary: str
    changes: Callable[[WorldConfig], dict[str, Any]] | None = None  # values by dotted key
    assignment: str = ""  # KEY=VALUE, if this is the only change
    policies: Policies = "trained"  # a name for all species, or a dict: species → name
    learn: bool | None = None  # whether policies learn during runs; None: as in the world file
    at_build: bool = False  # whether it is in `ecs_eco.life.treatments`
    needs_learning: bool = False  # whether it has no effect on runs without learning
    needs: str = ""  # what at least one species must have: policy, reflex or genome

    @property
    def changes_config(self) -> bool:
        """Whether it changes the configuration, so that policies can be trained under it."""
        return self.changes is not None or bool(self.assignment)

    def apply_to(self, config: WorldConfig) -> WorldConfig:
        """Return the configuration with this treatment. Raises NotApplicable, ConfigError."""
        if self.needs:
            _require(config, self.needs)
        if self.assignment:
            return load(config, [self.assignment])
        return config if self.changes is None else load(config, self.changes(config))


_TREATMENTS = (
    Treatment("random-policy", "actions are drawn at random", policies="random", needs="policy"),
    Treatment("untrained-policy", "networks start from random weights", policies="untrained"),
    Treatment("learning", "policies keep learning during the run", learn=True),
    Treatment("frozen", "policies do not learn during the run", learn=False),
    Treatment("individual-brains", "no network is shared", individual_brains, needs_learning=True),
    Treatment("no-reflexes", "reflexes are removed", at_build=True, needs="reflex"),
    Treatment("neutral-drift", "genes are inherited but not expressed", at_build=True, needs="genome"),
    Treatment("shuffled-genome", "genes come from random living members", at_build=True, needs="genome"),
    Treatment("no-mutation", "mutation is turned off", at_build=True, needs="genome"),
    Treatment("constant-light", "light is constant at its daily mean", partial(_sun, kind="constant")),
    Treatment("inverted-light", "day and night are swapped", partial(_sun, kind="inverted")),
    Treatment("no-smell", "no animal smells anything", no_smell),
    Treatment("energy-only", "happiness depends on energy alone", energy_only, needs_learning=True),
    Treatment("energy-and-light", "light lowers happiness", energy_and_light, needs_learning=True),
)
TREATMENTS: dict[str, Treatment] = {treatment.name: treatment for treatment in _TREATMENTS}
FORMER = {"frozen-learning": "frozen"}  # former names → current names
FOR_ONE_SPECIES = ("random-policy", "untrained-policy")  # such as random-policy:deer


def names(config: WorldConfig) -> list[str]:
    """Return the names of all treatments, whether or not they apply to this world."""
    return [*TREATMENTS, *(ABSENT + species for species in config.species)]


def find(name: str, config: WorldConfig) -> Treatment:
    """Return the treatment for a name or KEY=VALUE. Raises a ConfigError that suggests the closest name."""
    name = FORMER.get(name, name)
    kind, _, species = name.partition(":")
    one = TREATMENTS[kind] if kind in FOR_ONE_SPECIES else None
    if one is not None and species in species_with_policy(config):
        return replace(
            one, name=name, summary=f"{species}: {one.summary}", policies={species: str(one.policies)}
        )
    if name in TREATMENTS:
        return TREATMENTS[name]
    if name in names(config):
        absent = name.removeprefix(ABSENT)
        return Treatment(name, f"there is no {absent}", partial(without, species=absent))
    if "=" in name:
        return Treatment(name, name, assignment=name)
    if one is not None:
        known = species_with_policy(config)
        allowed = ", ".join(known) or "none"
        raise refusal((), "no such species with a policy", species, allowed, nearest(species, known), OPTION)
    allowed = (
        f"{', '.join(names(config))}, one of the first two for a single species (random-policy:NAME), or a "
        "changed value: key=value"
    )
    raise refusal((), "no such treatment", name, allowed, nearest(name, names(config)), OPTION)


def species_with_policy(config: WorldConfig) -> list[str]:
    """Return the names of the species that have a policy network."""
    return [name for name, species in config.species.items() if species.policy.thinks]


# bytes; file systems allow 255, and the names of some files contain this name
LONGEST_NAME = 100
UNTREATED = "world"  # name of the first arm


@dataclass(frozen=True)
class Arm:
    """One arm of a comparison."""

    name: str
    config: WorldConfig
    policies: Policies = "trained"  # or a dict: species → policies
    learn: bool | None = None  # None: as in the world file
    controls: tuple[str, ...] = ()  # names in ecs_eco.life.treatments
    treatment: Treatment | None = None  # None: the unchanged world

    @property
    def trained_species(self) -> list[str]:
        """Species with trained policies; only these depend on the training seed."""
        names = species_with_policy(self.config)
        chosen = self.policies if isinstance(self.policies, dict) else dict.fromkeys(names, self.policies)
        return [name for name in names if chosen.get(name, "trained") == "trained"]

    @property
    def learns(self) -> bool:
        """Whether any policy learns during the runs."""
        if self.learn is not None:
            return self.learn
        return any(self.config.species[name].policy.learn for name in species_with_policy(self.config))

    def with_policies(self, folder: Path) -> Self:
        """Return the arm with the trained policies in a folder, unless its treatment sets other policies."""
        if isinstance(self.policies, str):
            return replace(self, policies=str(folder)) if self.policies == "trained" else self
        by_species = {name: self.policies.get(name, str(folder)) for name in species_with_policy(self.config)}
        return replace(self, policies=by_species)


def arms_of(world: WorldSource, changes: list[str], treatments: Sequence[str]) -> list[Arm]:
    """Return the arms of the unchanged world and of each treatment (a name or KEY=VALUE)."""
    arms = [Arm(UNTREATED, load(world, changes))]
    for name in treatments:
        treatment = find(name, arms[0].config)
        try:
            # an assignment is loaded with the other changes, so that errors name the file and the line
            only = treatment.assignment
            config = load(world, [*changes, only]) if only else treatment.apply_to(arms[0].config)
        except NotApplicable as error:
            raise refusal((), error.what, treatment.name, error.allowed, source=OPTION) from None
        arm = arm_of(config, treatment)
        if any(other.name == arm.name for other in arms):
            raise refusal((), "named twice", name, "each treatment once", source=OPTION)
        arms.append(arm)
    return arms


def arm_of(config: WorldConfig, treatment: Treatment) -> Arm:
    """Return the arm of a treatment, given the configuration that it has changed."""
    controls = (treatment.name,) if treatment.at_build else ()
    return Arm(folder_name(treatment.name), config, treatment.policies, treatment.learn, controls, treatment)


def replicates(
    arm: Arm, training_seeds: Sequence[int], world_seeds: Iterable[int]
) -> Iterator[tuple[int | None, int]]:
    """Yield the training seed (None without trained policies) and world seed of each run of an arm."""
    return product((training_seeds if arm.trained_species else ()) or (None,), world_seeds)


def has_own_policies(arm: Arm, base: WorldConfig, retrain: bool) -> bool:
    """Return whether the policies of an arm are trained in its own configuration, not in the unchanged world."""
    return retrain and arm.config.config_hash != base.config_hash


def folder_name(treatment: str) -> str:
    """Return the folder name of a treatment: its letters, digits, dots and hyphens, shortened if long."""
    name = re.sub(r"[^\w.-]+", "-", treatment.strip()).strip("-.")
    if len(name.encode()) <= LONGEST_NAME:
        return name
    digest = hashlib.sha256(treatment.encode()).hexdigest()[:8]
    return f"{name.encode()[: LONGEST_NAME - 9].decode(errors='ignore')}-{digest}"


def problems_of_policies(policies: str, species: Sequence[str], base: Path = Path()) -> Iterator[Problem]:
    """Yield problems if `policies` is neither a known name nor a folder with a file for each species."""
    allowed = "trained, random, untrained, or a folder written by `ecs-eco train`"
    if policies not in POLICIES and not (base / policies).is_dir():
        fault = "no such folder"
        yield Problem(("policies",), fault, policies, allowed, nearest(policies, POLICIES))
    elif policies not in POLICIES:
        for name in species:
            if not (base / policies / f"{name}.safetensors").is_file():
                fault = f"{name}.safetensors is missing from the folder"
                yield Problem(("policies",), fault, policies, allowed)


def check_policies(policies: str, config: WorldConfig) -> None:
    """Raise ConfigError if the policies named on the command line do not exist."""
    if problem := next(problems_of_policies(policies, species_with_policy(config)), None):
        raise ConfigError([problem.moved(key=(), source="--policies")])


def check_training(arms: Sequence[Arm], training_seeds: int | None, retrain: bool) -> None:
    """Raise ConfigError if training options contradict each other or have no effect."""
    treated = [(arm, arm.treatment) for arm in arms if arm.treatment is not None]
    for arm, treatment in treated:
        if treatment.needs_learning and not retrain and not arm.learns:
            fault = "changes only learning, but nothing learns here"
            raise refusal((), fault, treatment.name, "--retrain --training-seeds N as well", source=OPTION)
    if retrain and training_seeds is None:
        raise refusal((), "nothing is trained", "", "--retrain with --training-seeds N", source="--retrain")
    if training_seeds is None:
        return
    if not species_with_policy(arms[0].config):
        allowed = 'a world with policy.kind = "shared"'
        raise refusal(
            (), "no species has a policy to train", training_seeds, allowed, source="--training-seeds"
        )
    changed = [treatment for _, treatment in treated if treatment.changes_config]
    if retrain and not changed:
        allowed = "--retrain with a --treatment that changes one, such as KEY=VALUE"
        raise refusal((), "no treatment changes a value", "", allowed, source="--retrain")
    for treatment in changed:
        if not retrain and treatment.name.strip().startswith("training."):
            fault = "changes only training, but all arms run with the same policies"
            raise refusal((), fault, treatment.name, "--retrain as well", source=OPTION)
