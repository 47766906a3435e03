"""Arms of a comparison: the unchanged world and the world under each treatment, with their policies."""

import hashlib
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Self

from ecs_eco.config import WorldConfig, load
from ecs_eco.config.loading import WorldSource
from ecs_eco.engine.errors import ConfigError, Problem, nearest, refusal
from ecs_eco.lab.treatments import OPTION, NotApplicable, Policies, Treatment, find, species_with_policy
from ecs_eco.worlds.policies import POLICIES

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
