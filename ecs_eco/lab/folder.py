"""The folder of a sweep: sweep.json with all that jobs need, so that you can move it, and a folder per job."""

import glob
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from ecs_eco.config import WorldConfig, load
from ecs_eco.config.document import Document
from ecs_eco.engine.errors import ForeignFile, refusal
from ecs_eco.engine.files import write
from ecs_eco.lab.design import Design, Job, Settings, Training, plan_folder, treated
from ecs_eco.lab.treatments import Arm, NotApplicable, species_with_policy
from ecs_eco.lab.work import evenly
from ecs_eco.record import container
from ecs_eco.record.code import FOLDER as CODE, check_code, keep_copies, noted, sources
from ecs_eco.record.manifest import Config, Tick

SWEEP, JOBS, DONE, FAILED, PROGRESS = "sweep.json", "jobs", "done.json", "failed.json", "progress.json"
RUN = "run"  # run folder within the job's folder
GIVEN = "given"  # folder for the policies named in a plan


class Manifest(container.Container):
    """The manifest of a sweep."""

    FILE: ClassVar = SWEEP
    KIND: ClassVar = "sweep"
    COMMAND: ClassVar = "sweep"
    OTHER: ClassVar = "contains the sweep of another plan"
    DECIDES: ClassVar = ("plan", "jobs")

    world: str
    title: str
    source: str
    ticks: Annotated[Tick, Field(ge=1)]
    checkpoint_every: Tick | None
    plan: Settings
    home: Annotated[str, Field(pattern=r"^world(/below)*$")]
    config: Config
    code: list[dict[str, str]]
    trainings: list[Training]
    jobs: Annotated[list[Job], Field(min_length=1)]

    @model_validator(mode="after")
    def _refers(self) -> Self:
        known = {None, *(training.name for training in self.trainings)}
        for number, job in enumerate(self.jobs):
            if job.number != number or job.training not in known:
                raise ValueError(f"jobs.{number}: has a wrong number or an unlisted training run")
        return self

    @classmethod
    def settings(cls, content: Mapping[str, Any]) -> dict[str, Any]:
        """Return the settings of a plan by key, and its worlds."""
        return {**content["plan"], "worlds": sorted({job["config_hash"] for job in content["jobs"]})}


@dataclass(frozen=True)
class Sweep:
    """A sweep, read from its folder."""

    folder: Path
    content: dict[str, Any]

    @property
    def hash(self) -> str:
        return str(self.content["hash"])

    @property
    def ticks(self) -> int:
        return int(self.content["ticks"])

    def may_continue(self) -> None:
        """Raise ForeignFile if the sweep began in the other numerical mode, or a link leads out of its folder."""
        container.may_continue(self.folder / SWEEP, {"target": self.content})

    @cached_property
    def jobs(self) -> tuple[Job, ...]:
        return tuple(Job(**job) for job in self.content["jobs"])

    def evenly(self, numbers: Iterable[int]) -> list[int]:
        """Return jobs ordered so that points, treatments and seeds advance evenly."""
        return evenly(numbers, lambda n: self.jobs[n].point, lambda n: self.jobs[n].treatment)

    @cached_property
    def trainings(self) -> dict[str, Training]:
        return {one["name"]: Training(**one) for one in self.content["trainings"]}

    def job_folder(self, number: int) -> Path:
        """Return the folder of a job. Raises ConfigError if the number is unknown."""
        if not 0 <= number < len(self.content["jobs"]):
            allowed = f"a number from 0 to {len(self.content['jobs']) - 1}"
            raise refusal((), "no such job", number, allowed, source="NUMBER")
        return self.folder / JOBS / f"{number:04d}"

    def policies_folder(self, training: str) -> Path:
        return container.inside(self.folder, self.folder / "policies") / training

    def training(self, name: str) -> tuple[Path, WorldConfig, int]:
        """Return the arguments of `trained.train_or_find`."""
        one = self.trainings[name]
        return self.policies_folder(name), self.world(one.values, one.treatment).config, one.seed

    def world(self, values: dict[str, Any], treatment: str) -> Arm:
        """Return the world with these values and this treatment. Raises ConfigError, ForeignFile."""
        try:
            return treated(load(self.base, values), treatment)
        except NotApplicable as error:
            raise ForeignFile(
                f"{self.folder / SWEEP}: treatment: {treatment!r} {error.what}; expected: {error.allowed}"
            ) from None

    def arm(self, job: Job) -> Arm:
        """Return the arm of a job, with its policies. Raises ForeignFile if its world has changed."""
        arm = self.world(job.values, job.treatment)
        if arm.config.config_hash != job.config_hash:
            raise ForeignFile(
                f"{self.folder / SWEEP}: {job} has a different configuration than when the sweep began, "
                "because the version of ecs-eco or the world's code has changed"
            )
        if job.training is not None:
            return arm.with_policies(self.policies_folder(job.training))
        given = self.content["plan"]["policies"]
        if given == "trained":
            return arm
        return arm.with_policies(Path(given) if isinstance(given, str) else self.folder / "policies" / GIVEN)

    @cached_property
    def base(self) -> WorldConfig:
        """The world before values vary."""
        check_code(self.content["code"], [self.folder / CODE], str(self.folder / SWEEP))
        home = self.folder / self.content["home"]
        return load(Document(self.content["config"], SWEEP, home, places=[self.folder / CODE]))


def read_sweep(folder: str | Path) -> Sweep:
    """Return the sweep in a folder.

    Parameters
    ----------
    folder : str or Path
        Folder of a finished or unfinished sweep.

    Returns
    -------
    Sweep
        The sweep's plan and jobs.

    Raises
    ------
    RecordingError
        If there is no sweep or it is damaged.

    Examples
    --------
    >>> from ecs_eco.lab import run_sweep
    >>> plan = {"world": "predator-prey", "ticks": 10, "grid": {"species.deer.metabolism.basal": [0.004]}}
    >>> outcome = run_sweep(plan, "swept", workers=1)
    >>> from ecs_eco.lab.folder import read_sweep
    >>> read_sweep("swept").ticks
    10
    """
    path = Path(os.path.abspath(folder))
    try:
        status = (path / SWEEP).stat()
    except OSError:
        container.read(folder, Manifest)
        raise
    return _read(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=4)
def _read(folder: Path, written: int, size: int) -> Sweep:
    return Sweep(folder, container.read(folder, Manifest))


def begin(folder: Path, design: Design) -> Sweep:
    """Write a design's sweep to a folder unless it is already there, and return it. Raises ForeignFile if the
    folder contains a sweep with a different plan."""
    names, home = _named(design)
    container.begin(
        folder,
        Manifest,
        design.planned
        | {
            "world": design.base.name,
            "title": design.file.plan.title or design.base.title,
            "source": design.file.document.source,
            "ticks": design.ticks,
            "checkpoint_every": design.file.plan.checkpoint_every,
            "home": home.as_posix(),
            "config": design.base.resolved(),
            "code": noted(sources(design.base)),
            "trainings": [asdict(one) for one in design.trainings],
        },
    )
    _keep_files(folder, design, names, home)  # completes the copies of a command that was killed here
    return read_sweep(folder)


def _named(design: Design) -> tuple[list[str], Path]:
    """Return the files that a world names, and the path that replaces the world's folder."""
    policies = [s.policy.file for s in design.base.species.values() if s.policy.file is not None]
    names = [n for n in (*policies, *named_files(design.base.resolved())) if not os.path.isabs(n)]
    ups = max([Path(os.path.normpath(name)).parts.count("..") for name in names], default=0)
    return names, Path("world", *["below"] * ups)  # deep enough for files above the world's folder


def _keep_files(folder: Path, design: Design, names: Iterable[str], home: Path) -> None:
    """Copy the code and files of the world and the plan that are not there yet."""
    container.inside(folder, folder / home.parts[0])
    (folder / home).mkdir(parents=True, exist_ok=True)
    keep_copies([s for s in sources(design.base) if not (folder / CODE / s.entry).exists()], folder)
    for name in names:
        copy_file(design.base.file(name), Path(os.path.normpath(folder / home / name)))
    given = plan_folder(design.file)
    for name in species_with_policy(design.base) if given is not None else ():
        copy_file(given / f"{name}.safetensors", folder / "policies" / GIVEN / f"{name}.safetensors")  # type: ignore[operator]


def named_files(world: Mapping[str, Any]) -> list[str]:
    """Return the rasters, layers and measurements that a world's values name."""
    land, data = world.get("terrain") or {}, world.get("data") or {}
    names = land.get("raster"), land.get("cover"), data.get("file")
    return [name for name in (*names, *(layer["file"] for layer in land.get("layers") or ())) if name]


def copy_file(path: Path, copy: Path) -> None:
    """Copy a file, if it exists, and files with the same stem: a Shapefile has several. Copies are not replaced."""
    for part in path.parent.glob(f"{glob.escape(path.stem)}.*") if path.is_file() else ():
        if part.is_file() and not (to := copy.with_suffix(part.suffix)).exists():
            copy.parent.mkdir(parents=True, exist_ok=True)
            write(to, part.read_bytes())
