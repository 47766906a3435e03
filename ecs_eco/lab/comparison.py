"""A comparison: a world with and without treatments, run with the same seeds and stored in one folder."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from pydantic import Field

from ecs_eco.analysis.compare import compare as differences
from ecs_eco.config import WorldConfig
from ecs_eco.config.loading import WorldSource
from ecs_eco.engine.arguments import called_with
from ecs_eco.inputs.section import Section
from ecs_eco.lab.executors import LOCAL, engine, prepare
from ecs_eco.lab.jobs import has_run, is_trained, run_arm, train_or_find
from ecs_eco.lab.treatments import (
    Arm,
    arms_of,
    check_training,
    has_own_policies,
    replicates,
    species_with_policy,
)
from ecs_eco.lab.work import evenly, group, run_jobs
from ecs_eco.record import container
from ecs_eco.record.claim import ours
from ecs_eco.record.manifest import Filename, Sha, Tick
from ecs_eco.worlds.policies import POLICIES


class PlannedArm(Section):
    """The settings of an arm that affect its results."""

    config_hash: Sha
    policies: str | dict[str, str]
    learn: bool | dict[str, bool] | None
    controls: list[str]


class Planned(container.Container):
    """The manifest of a comparison, without the number of seeds, so that seeds and arms can be added."""

    FILE: ClassVar = "plan.json"
    KIND: ClassVar = "comparison"
    COMMAND: ClassVar = "compare"
    OTHER: ClassVar = "contains another comparison"
    DECIDES: ClassVar = ("world", "ticks", "training seeds", "retrain")
    GROWS: ClassVar = True

    world: str
    ticks: Tick
    trains: bool = Field(alias="training seeds")
    retrain: bool
    arms: dict[Filename, PlannedArm]

    @classmethod
    def settings(cls, content: Mapping[str, Any]) -> dict[str, Any]:
        """Return the settings of a comparison, with a separate entry for each arm."""
        return super().settings(content) | {f"the arm {name}": arm for name, arm in content["arms"].items()}


class Key(NamedTuple):
    """The name of a job."""

    arm: str
    seed: int
    training_seed: int | None = None

    def __str__(self) -> str:
        text = f"{self.arm}, seed {self.seed}"
        return text if self.training_seed is None else f"{text}, training seed {self.training_seed}"


Run = tuple[Arm, int, int, Path]  # arguments of `jobs.run_arm`
Training = tuple[Path, WorldConfig, int]  # arguments of `trained.train_or_find`


@dataclass(frozen=True)
class Comparison:
    """The arms (the unchanged world first), the seeds of each arm, and their folder."""

    folder: Path
    arms: Sequence[Arm]
    ticks: int
    world_seeds: Sequence[int]
    training_seeds: Sequence[int] | None = None  # None: no training
    retrain: bool = False  # whether arms with changed values train their own policies

    @property
    def plan(self) -> dict[str, Any]:
        """The settings that identify the comparison, as in plan.json."""
        return {
            "world": self.arms[0].config.name,
            "ticks": self.ticks,
            "training seeds": self.training_seeds is not None,
            "retrain": self.retrain,
            "arms": {
                arm.name: {
                    "config_hash": arm.config.config_hash,
                    "policies": arm.policies,
                    "learn": arm.learn,
                    "controls": list(arm.controls),
                }
                for arm in self.arms
            },
        }

    def begin(self) -> None:
        """Write the settings to the folder, keeping the arms already there. Raises ForeignFile if it contains
        another comparison, or one begun in the other numerical mode."""
        there = container.begin(self.folder, Planned, self.plan)
        if self.plan["arms"].keys() - there["arms"].keys():
            container.write(self.folder, Planned, there | {"arms": there["arms"] | self.plan["arms"]})

    def result(self) -> dict[str, Any]:
        """Compare the arms; write compare.json, compare.html and figures; return the contents of compare.json."""
        arms = group(self.runs, lambda key: key.arm)
        folders = {arm: [self.runs[key][-1] for key in own] for arm, own in arms.items()}
        training = {
            arm: seeds
            for arm, own in arms.items()
            if (seeds := [key.training_seed for key in own if key.training_seed is not None])
        }
        return differences(folders, self.folder, training=training, policies=self.policies_in_words())

    def policies_folder(self, arm: Arm) -> Path:
        """Return the folder of an arm's policies, which has a subfolder per training seed."""
        own = has_own_policies(arm, self.arms[0].config, self.retrain)
        return self.folder / "policies" / (arm if own else self.arms[0]).name

    @cached_property
    def trainings(self) -> dict[Path, Training]:
        """Return all training runs, by folder."""
        owners = {self.policies_folder(arm): arm for arm in reversed(self.arms) if arm.trained_species}
        return {
            folder: (folder, arm.config, k)
            for place, arm in owners.items()
            for k in self.training_seeds or ()
            for folder in [container.inside(self.folder, place / f"seed-{k}")]
        }

    @cached_property
    def runs(self) -> dict[Key, Run]:
        """Return all runs, ordered by arm, training seed and world seed."""
        jobs = {}
        for arm in self.arms:
            for k, seed in replicates(arm, self.training_seeds or (), self.world_seeds):
                treated, folder = arm, self.folder / arm.name
                if k is not None:
                    treated = arm.with_policies(self.policies_folder(arm) / f"seed-{k}")
                    folder = folder / f"training-{k}"
                folder = container.inside(self.folder, folder / f"seed-{seed}")
                jobs[Key(arm.name, seed, k)] = treated, seed, self.ticks, folder
        return jobs

    def left(self) -> tuple[dict[Key | Path, Sequence[Any]], dict[Key | Path, Key | Path]]:
        """Return the calls for training and runs that are not done, with arms and seeds advancing evenly, and the
        training that a run waits for. Raises ForeignFile if a folder contains something else."""
        calls: dict[Key | Path, Sequence[Any]] = {
            place: (train_or_find, *job) for place, job in self.trainings.items() if not is_trained(*job)
        }
        runs = [key for key, job in self.runs.items() if not has_run(*job)]
        arms = {arm.name: self.policies_folder(arm) for arm in self.arms}
        after: dict[Key | Path, Key | Path] = {
            key: place for key in runs if (place := arms[key.arm] / f"seed-{key.training_seed}") in calls
        }
        return calls | {key: (run_arm, *self.runs[key]) for key in evenly(runs, lambda key: key.arm)}, after

    def policies_in_words(self) -> dict[str, str]:
        arms = [
            arm for arm in self.arms if self.training_seeds is not None or species_with_policy(arm.config)
        ]
        return {arm.name: self._policies(arm) for arm in arms}

    def _policies(self, arm: Arm) -> str:
        seeds = self.training_seeds
        if seeds is None and isinstance(arm.policies, str) and arm.policies not in POLICIES:
            return f"the policies in {arm.policies}"
        if not (trained := arm.trained_species):
            return "untrained policies" + ("" if seeds is None else " and has no training seed")
        own = has_own_policies(arm, self.arms[0].config, self.retrain)
        same = "" if own or arm is self.arms[0] else ", the same as the first arm"
        some = "" if trained == species_with_policy(arm.config) else f" of {', '.join(trained)}"
        if seeds is None:
            return f"the world's own policies{some}{same}"
        how = "trained again with its own values" if own else "trained in the unchanged world"
        return f"policies{some} {how}{same}, from {len(seeds)} training seed{'s' * (len(seeds) != 1)}"


def comparison_of(
    arms: Sequence[Arm],
    folder: Path,
    seeds: int,
    ticks: int | None,
    training_seeds: int | None,
    retrain: bool,
) -> Comparison:
    """Return the comparison of these arms in a folder. Raises ConfigError for contradictory training options."""
    check_training(arms, training_seeds, retrain)
    training = None if training_seeds is None else range(1, training_seeds + 1)
    return Comparison(folder, arms, ticks or arms[0].config.ticks, range(1, seeds + 1), training, retrain)


def compare(
    world: WorldSource,
    treatments: Sequence[str] = ("random-policy",),
    *,
    out: str | Path,
    changes: Sequence[str] = (),
    seeds: int = 8,
    ticks: int | None = None,
    training_seeds: int | None = None,
    retrain: bool = False,
    executor: str | Executor = LOCAL,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Run a world with and without treatments, using the same seeds, and compare the outcomes.

    Parameters
    ----------
    world : str, Path, Mapping or WorldConfig
        The world, as in `World.from_config`.
    treatments : sequence of str, default ("random-policy",)
        Names of treatments, or changes such as "species.deer.metabolism.basal=0.008".
    out : str or Path
        Folder for all runs. If it already contains this comparison, the comparison is resumed.
    changes : sequence of str
        Changes to the values of all arms, such as "species.deer.count=300".
    seeds : int, default 8
        Number of world seeds, counted from 1.
    ticks : int, optional
        Length of a run; default: `ticks` in the world file.
    training_seeds : int, optional
        Number of training seeds, each combined with all world seeds; default: use the policies of the world
        file.
    retrain : bool, default False
        Whether arms with changed values train their own policies.
    executor : str or Executor, default "local"
        "local" (`workers` processes), "ray", or an executor whose workers can access the folder under its
        absolute path.
    workers : int, optional
        Number of processes; default: 2, or all CPUs of a Ray cluster.
    progress : callable, optional
        `progress(done, total)`, called after each training and each run.

    Returns
    -------
    dict
        Contents of compare.json: persistence, cycles and differences of each arm, with intervals.

    Raises
    ------
    ConfigError
        If the world or a treatment is invalid.
    ForeignFile
        If the folder contains another comparison.

    Examples
    --------
    >>> from ecs_eco.lab import compare
    >>> result = compare("predator-prey", out="compared", seeds=2, ticks=20, workers=1)
    >>> sorted(result["arms"])
    ['random-policy', 'world']
    """
    called_with("progress", progress, "done", "total")
    arms = arms_of(world, list(changes), treatments)
    folder = Path(out).absolute()
    comparison = comparison_of(arms, folder, seeds, ticks, training_seeds, retrain)
    errors: list[BaseException] = []
    with ours(folder), engine(executor, workers) as pool:
        comparison.begin()
        prepare(pool, folder, arms[0].config)
        calls, after = comparison.left()
        run_jobs(
            calls, pool, progress or (lambda *_: None), lambda _, error: errors.append(error), after=after
        )
        if errors:
            raise errors[0]
        return comparison.result()
