"""A comparison: arms, each run with the same seeds, its jobs and which are done; the caller has the pool."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from ecs_eco.config import WorldConfig
from ecs_eco.lab.arm import Arm
from ecs_eco.lab.comparison_plan import plan_of
from ecs_eco.lab.executors import completed
from ecs_eco.lab.runs import has_run
from ecs_eco.lab.trained import is_trained
from ecs_eco.lab.treatments import species_with_policy
from ecs_eco.record.container import inside
from ecs_eco.worlds.policies import POLICIES

Result = TypeVar("Result")


class Key(NamedTuple):
    """The name of a job."""

    arm: str
    seed: int
    training_seed: int | None = None

    def __str__(self) -> str:
        text = f"{self.arm}, seed {self.seed}"
        return text if self.training_seed is None else f"{text}, training seed {self.training_seed}"


class Run(NamedTuple):
    """Arguments of `runs.run_arm`."""

    arm: Arm
    seed: int
    ticks: int
    folder: Path

    @property
    def done(self) -> bool:
        """Whether it is done already. Raises ForeignFile where another run is in its folder."""
        return has_run(self.folder, self.ticks, self.arm, self.seed)


class Training(NamedTuple):
    """Arguments of `trained.train_or_find`."""

    folder: Path
    config: WorldConfig
    seed: int

    @property
    def done(self) -> bool:
        """Whether it is done already. Raises ForeignFile where another training is in its folder."""
        return is_trained(*self)


@dataclass(frozen=True)
class Comparison:
    """Arms, the first of which is the world as it is, and the seeds that all are run with, in a folder."""

    folder: Path
    arms: Sequence[Arm]
    ticks: int
    world_seeds: Sequence[int]
    training_seeds: Sequence[int] | None = None  # None: nothing is trained
    retrain: bool = False  # whether arms with another configuration have policies that were trained in it

    @property
    def plan(self) -> dict[str, Any]:
        """What plan.json holds."""
        return plan_of(self.arms, self.ticks, self.training_seeds is not None, self.retrain)

    def trains(self, arm: Arm) -> bool:
        """Return whether an arm runs with policies that are trained for the comparison."""
        return self.training_seeds is not None and bool(arm.trained_species)

    def has_own_policies(self, arm: Arm) -> bool:
        """Return whether the policies of an arm are trained in its own configuration."""
        return self.retrain and arm.config.config_hash != self.arms[0].config.config_hash

    def policies_folder(self, arm: Arm) -> Path:
        """Return where the policies of an arm are, by training seed."""
        owner = arm if self.has_own_policies(arm) else self.arms[0]
        return self.folder / "policies" / owner.name

    @cached_property
    def trainings(self) -> dict[Key, Training]:
        """All trainings."""
        owners = {self.policies_folder(arm): arm for arm in reversed(self.arms) if self.trains(arm)}
        return {
            Key(place.name, seed): Training(inside(self.folder, place / f"seed-{seed}"), arm.config, seed)
            for place, arm in owners.items()
            for seed in self.training_seeds or ()
        }

    @cached_property
    def runs(self) -> dict[Key, Run]:
        """All runs, in the order of arms, training seeds and world seeds."""
        jobs = {}
        for arm in self.arms:
            for k in (self.training_seeds or ()) if self.trains(arm) else (None,):
                treated, folder = arm, self.folder / arm.name
                if k is not None:
                    treated = arm.with_policies(self.policies_folder(arm) / f"seed-{k}")
                    folder = folder / f"training-{k}"
                for seed in self.world_seeds:
                    jobs[Key(arm.name, seed, k)] = Run(
                        treated, seed, self.ticks, inside(self.folder, folder / f"seed-{seed}")
                    )
        return jobs

    def folders(self) -> dict[str, list[Path]]:
        """Return the folders of all runs by arm."""
        return {
            arm.name: [run.folder for key, run in self.runs.items() if key.arm == arm.name]
            for arm in self.arms
        }

    def training_seeds_of_runs(self) -> dict[str, list[int]] | None:
        """Return the training seeds of runs, by arm that has some; None where nothing is trained."""
        if self.training_seeds is None:
            return None
        seeds: dict[str, list[int]] = {}
        for key in self.runs:
            if key.training_seed is not None:
                seeds.setdefault(key.arm, []).append(key.training_seed)
        return seeds

    def policies_in_words(self) -> dict[str, str]:
        """Describe the policies that each arm runs with."""
        if self.training_seeds is None:
            return {arm.name: self._bundled(arm) for arm in self.arms if species_with_policy(arm.config)}
        return {arm.name: self._trained(arm) for arm in self.arms}

    def _bundled(self, arm: Arm) -> str:
        if isinstance(arm.policies, str) and arm.policies not in POLICIES:
            return f"the policies in {arm.policies}"
        if not arm.trained_species:
            return "policies that are not trained"
        same = "" if arm is self.arms[0] else ", the same as the first arm"
        return f"the world's own policies{_of_some(arm)}{same}"

    def _trained(self, arm: Arm) -> str:
        if not arm.trained_species:
            return "policies that are not trained: it has no training seed"
        own, n = self.has_own_policies(arm), len(self.training_seeds or ())
        how = "trained anew under its own values" if own else "trained in the world as it is"
        same = "" if own or arm is self.arms[0] else ", the same as the first arm"
        return f"policies{_of_some(arm)} {how}{same}, from {n} training seed{'s' * (n != 1)}"


def _of_some(arm: Arm) -> str:
    """Return the species that run with trained policies, in words, where others of the arm do not."""
    trained = arm.trained_species
    return "" if trained == species_with_policy(arm.config) else f" of {', '.join(trained)}"


def run_jobs(
    work: Callable[..., Result],
    jobs: Mapping[Key, Sequence[Any]],
    pool: Executor,
    progress: Callable[[int, int], None],
    failed: Callable[[Key, BaseException], None],
) -> dict[Key, Result]:
    """Do all jobs on an executor; return the results of those that succeeded.

    `progress` is called with the number of successes and of jobs, `failed` with a job and its exception; with
    BrokenExecutor, once, if a worker was killed from outside: then no other job is begun.
    """
    results: dict[Key, Result] = {}
    if not jobs:
        return results
    progress(0, len(jobs))
    for key, future in completed(pool, work, jobs):
        error = future.exception()
        if error is None:
            results[key] = future.result()
        else:
            failed(key, error)
            if isinstance(error, BrokenExecutor):
                break
        progress(len(results), len(jobs))
    return results
