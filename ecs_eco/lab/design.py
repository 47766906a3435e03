"""The design of a sweep: a fully checked plan, all of whose worlds load, with its jobs and training runs."""

from collections.abc import Container, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import islice
from math import prod
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field

from ecs_eco.config import Section, WorldConfig, load
from ecs_eco.config.checks.reporters import problems_of_rules
from ecs_eco.config.document import Document, read_document
from ecs_eco.config.ranges import Key, key_of
from ecs_eco.config.shipped import named, shipped
from ecs_eco.engine.errors import MOST, ConfigError, Problem, nearest
from ecs_eco.lab.plan import MOST_JOBS, PlanFile, Point, Sample, points_of, problems_of_ranges
from ecs_eco.lab.treatments import (
    UNTREATED,
    Arm,
    NotApplicable,
    arm_of,
    find,
    has_own_policies,
    problems_of_policies,
    replicates,
    species_with_policy,
)
from ecs_eco.learning.weights import hash_of
from ecs_eco.record.manifest import Seed, Sha, Tick
from ecs_eco.worlds.policies import POLICIES

NAME = r"^[0-9a-f]{16}/seed-[0-9]+$"  # name of a training run: its world and its seed


class Settings(Section):
    """The settings of a plan that are read back; all other settings only distinguish plans."""

    model_config = ConfigDict(extra="allow", strict=True)

    policies: Literal["trained", "random", "untrained"] | dict[str, Sha]
    world_seeds: list[Seed]
    training_seeds: list[Seed]
    until: list[str] = []
    from_tick: Tick = 0
    latin_hypercube: Sample | None = None


@dataclass(frozen=True)
class Training:
    """Policies to train once, in the world with these values and this treatment."""

    __pydantic_config__: ClassVar[ConfigDict] = Section.model_config

    name: Annotated[str, Field(pattern=NAME)]  # folder in the sweep's policies/
    seed: Seed
    values: dict[str, Any]
    treatment: str
    config_hash: Sha


@dataclass(frozen=True)
class Job:
    """One run of a sweep."""

    __pydantic_config__: ClassVar[ConfigDict] = Section.model_config

    number: int
    point: int
    values: dict[str, Any]
    treatment: str  # "": the unchanged world
    training_seed: Seed | None
    world_seed: Seed
    training: str | None  # name of the training run
    config_hash: Sha

    def __str__(self) -> str:
        values = ", ".join(f"{name.rpartition('.')[2]} {value}" for name, value in self.values.items())
        seeds = "" if self.training_seed is None else f", training seed {self.training_seed}"
        parts = [values, self.treatment, f"seed {self.world_seed}{seeds}"]
        return f"job {self.number} ({'; '.join(part for part in parts if part)})"


@dataclass(frozen=True)
class Design:
    """A checked plan: the world before values vary, the jobs, and the training runs that they need."""

    file: PlanFile
    base: WorldConfig
    ticks: int
    jobs: tuple[Job, ...]
    trainings: tuple[Training, ...]

    @property
    def planned(self) -> dict[str, Any]:
        """The jobs, and the settings that affect results, as JSON, wherever the files of a plan are."""
        exclude = {"title", "world", "checkpoint_every"}
        plan = self.file.plan.model_dump(mode="json", by_alias=True, exclude=exclude)
        seeds = {f"{kind}_seeds": list(self.file.plan.seeds(kind)) for kind in ("world", "training")}
        if (given := plan_folder(self.file)) is not None:
            plan["policies"] = {
                name: hash_of(given / f"{name}.safetensors") for name in species_with_policy(self.base)
            }
        more = {"ticks": self.ticks, "world": self.base.name, "world_hash": self.base.config_hash}
        return {"plan": plan | seeds | more, "jobs": [asdict(job) for job in self.jobs]}


def design_of(file: PlanFile, *, trust: bool = False) -> Design:
    """Return the design of a plan; `trust` allows code listed in its world file to run in this process.
    Raises a ConfigError that lists all problems with their lines."""
    plan = file.plan
    base = _base(file, trust)
    if (
        n := len(plan.list or [()])
        * (plan.sample.size if plan.sample else 1)
        * prod(map(len, (plan.grid or {}).values()))
        * (1 + len(plan.treatments))
        * len(plan.seeds("world"))
        * max(1, len(plan.seeds("training")))
    ) > MOST_JOBS:
        raise file.refused([Problem(("grid",), f"makes {n:,} jobs", allowed=f"at most {MOST_JOBS:,}")])
    problems = [
        *_of_policies(file, base),
        *problems_of_ranges(plan, base),
        *problems_of_rules(base, plan.until),
    ]
    if plan.from_tick >= (ticks := plan.ticks or base.ticks):
        fault, allowed = "is not before the end of the runs", f"less than {ticks}"
        problems.append(Problem(("from_tick",), fault, plan.from_tick, allowed))
    if problems:
        raise file.refused(problems)
    arms: list[tuple[dict[str, Any], str, Arm]] = []
    problems = list(islice(_arms(file, base, arms), MOST))
    if problems:
        raise file.refused(list({(p.key, p.what): p for p in problems}.values()))
    jobs, trainings = _jobs(file, base, arms)
    return Design(file, base, ticks, tuple(jobs), tuple(trainings.values()))


def _base(file: PlanFile, trust: bool) -> WorldConfig:
    """Return the world of a plan, with the values and reporters shared by all runs."""
    plan, document = file.plan, _document(file)
    document.set_by = file.document.source
    values = plan.set | {f'reporters."{name}"': what for name, what in plan.reporters.items()}
    try:
        return load(document, values, trust=trust)
    except ConfigError as error:
        places: dict[Key, Key] = {key_of(name): ("set", name) for name in plan.set}
        places |= {("reporters", name): ("reporters", name) for name in plan.reporters}
        problems = []
        for problem in error.problems:
            if problem.source == file.document.source:
                key = _known_part(problem.key, places)
                problem = problem.moved(key=() if key is None else places[key], source="")
            problems.append(problem)
        raise file.refused(problems) from None


def _document(file: PlanFile) -> Document:
    """Return the document of a plan's world."""
    given, world = file.document.data["world"], file.plan.world
    if not isinstance(given, str):
        return read_document(given)
    try:
        return read_document(world if named(world) is not None else str(file.document.folder / world))
    except ConfigError as error:
        first = error.problems[0]
        if first.source != "WORLD":
            raise
        near = nearest(world, [*shipped(), *(p.name for p in file.document.folder.glob("*.toml"))])
        raise file.refused([first.moved(key=("world",), value=world, source="", nearest=near)]) from None


def _known_part(key: Key, known: Container[Key]) -> Key | None:
    """Return the longest known prefix of a key."""
    return next((key[:n] for n in range(len(key), 0, -1) if key[:n] in known), None)


def _of_policies(file: PlanFile, base: WorldConfig) -> Iterator[Problem]:
    plan, known = file.plan, species_with_policy(base)
    if plan.retrain and plan.training_seeds is None:
        yield Problem(("retrain",), "nothing is trained", True, "training_seeds = N as well")
    if plan.training_seeds is not None and not known:
        yield Problem(
            ("training_seeds",),
            "no species has a policy to train",
            plan.training_seeds,
            'a world with policy.kind = "shared"',
        )
    if plan.policies == "trained":
        return
    if plan.training_seeds is not None:
        yield Problem(
            ("policies",), "policies are trained for this sweep", plan.policies, "policies, or training_seeds"
        )
    else:
        yield from problems_of_policies(plan.policies, known, file.document.folder)


def _arms(
    file: PlanFile, base: WorldConfig, arms: list[tuple[dict[str, Any], str, Arm]]
) -> Iterator[Problem]:
    """Load the worlds of all points and treatments into `arms`, in order, and yield their problems."""
    for point in points_of(file.plan, base):
        values = {name: entry.value for name, entry in point.items()}
        try:
            config = load(base, values)
        except ConfigError as error:
            yield from (_at_value(problem, point) for problem in error.problems)
            continue
        if vain := [] if file.plan.retrain else [name for name in point if key_of(name)[0] == "training"]:
            fault = "changes only training, but all jobs run with the same policies"
            yield Problem(point[vain[0]].place, fault, values[vain[0]], "retrain = true as well")
        for i, treatment in enumerate(("", *file.plan.treatments), -1):
            try:
                arms.append((values, treatment, treated(config, treatment)))
            except NotApplicable as error:
                yield Problem(("treatments", i), error.what, treatment, error.allowed)
            except ConfigError as error:
                yield error.problems[0].moved(key=("treatments", i), value=treatment, source="", line=None)


def treated(config: WorldConfig, treatment: str) -> Arm:
    """Return the arm of a treatment ("" is the unchanged world). Raises NotApplicable, ConfigError."""
    if not treatment:
        return Arm(UNTREATED, config)
    what = find(treatment, config)
    return arm_of(what.apply_to(config), what)


def _at_value(problem: Problem, point: Point) -> Problem:
    """Return a problem with a world, located at the point's value that causes it."""
    names = {key_of(name): name for name in point}
    if (key := _known_part(problem.key, names)) is not None:
        own = names[key]
        deeper = "" if key_of(own) == problem.key else f"{problem.path}: "
        return problem.moved(
            key=point[own].place, value=point[own].value, source="", line=None, what=deeper + problem.what
        )
    words = ", ".join(f"{name} = {entry.value}" for name, entry in point.items())
    return problem.moved(
        key=next(iter(point.values())).place if point else ("world",),
        source="",
        line=None,
        what=f"with {words}: {problem.path}: {problem.what}" if words else problem.what,
    )


def _jobs(
    file: PlanFile, base: WorldConfig, arms: Sequence[tuple[dict[str, Any], str, Arm]]
) -> tuple[list[Job], dict[str, Training]]:
    """Return all jobs, ordered by point, treatment and seeds, and the training runs that they need."""
    plan, jobs, trainings = file.plan, list[Job](), dict[str, Training]()
    per_point = 1 + len(plan.treatments)
    for at, (values, treatment, arm) in enumerate(arms):
        own, world = has_own_policies(arm, base, plan.retrain), arm.config.config_hash
        trained_in = world if own else base.config_hash
        for training_seed, seed in replicates(arm, plan.seeds("training"), plan.seeds("world")):
            name = None
            if training_seed is not None:
                name, source = (
                    f"{trained_in[:16]}/seed-{training_seed}",
                    (values, treatment) if own else ({}, ""),
                )
                trainings.setdefault(name, Training(name, training_seed, *source, trained_in))
            jobs.append(Job(len(jobs), at // per_point, values, treatment, training_seed, seed, name, world))
    return jobs, trainings


def plan_folder(file: PlanFile) -> Path | None:
    """Return the policy folder named in a plan, if any."""
    return None if file.plan.policies in POLICIES else file.document.folder / file.plan.policies
