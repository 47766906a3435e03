"""The folder of a sweep: sweep.json with its plan, its world and its jobs; a folder for each job.

It holds all that a job needs, so that it may lie on a disk that many machines share, and be moved.
"""

from __future__ import annotations

import json
import os
import shutil
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from ecs_eco.config import WorldConfig, load
from ecs_eco.config.document import Document
from ecs_eco.engine import portable
from ecs_eco.engine.errors import ConfigError, ForeignFile, Problem, RecordingError
from ecs_eco.engine.files import write_json
from ecs_eco.experiments.arm import Arm
from ecs_eco.experiments.treatments import species_with_policy
from ecs_eco.record.code import FOLDER as CODE
from ecs_eco.record.code import check_code, keep_copies, noted, sources
from ecs_eco.sweeps.design import Design, Job, Training, as_json, plan_folder, treated

SWEEP, JOBS, DONE, FAILED, PROGRESS = "sweep.json", "jobs", "done.json", "failed.json", "progress.json"
RUN = "run"  # the run's folder within that of its job
GIVEN = "given"  # folder of the policies that a plan names
FORMAT = 1


@dataclass(frozen=True)
class Sweep:
    """A sweep as its folder holds it."""

    folder: Path
    content: dict[str, Any]

    @property
    def hash(self) -> str:
        """The hash of its plan."""
        return str(self.content["hash"])

    @property
    def ticks(self) -> int:
        """Length of each run."""
        return int(self.content["ticks"])

    def check_mode(self) -> None:
        """Raise ForeignFile where the sweep was begun in another mode than this process computes in."""
        if why := portable.other_mode({"target": {"mode": self.content.get("mode", "native")}}):
            raise ForeignFile(f"{self.folder / SWEEP}: {why}")

    @cached_property
    def jobs(self) -> tuple[Job, ...]:
        """All jobs."""
        return tuple(Job(**job) for job in self.content["jobs"])

    @cached_property
    def trainings(self) -> dict[str, Training]:
        """All trainings, by name."""
        return {one["name"]: Training(**one) for one in self.content["trainings"]}

    def job_folder(self, number: int) -> Path:
        """Return the folder of a job. Raises ConfigError for a number that no job has."""
        if not 0 <= number < len(self.content["jobs"]):
            allowed = f"a number from 0 to {len(self.content['jobs']) - 1}"
            raise ConfigError([Problem((), "no such job", number, allowed, source="NUMBER")])
        return self.folder / JOBS / f"{number:04d}"

    def policies_folder(self, training: str) -> Path:
        """Return the folder of policies that a training leaves."""
        return self.folder / "policies" / training

    def world(self, values: dict[str, Any], treatment: str) -> Arm:
        """Return the world with these values under a treatment. Raises ConfigError."""
        return treated(load(self.base, values), treatment)

    def arm(self, job: Job) -> Arm:
        """Return the arm of a job with its policies. Raises ForeignFile where its world is another now."""
        arm = self.world(job.values, job.treatment)
        if arm.config.config_hash != job.config_hash:
            raise ForeignFile(f"{self.folder / SWEEP}: {job} has another configuration than when the sweep "
                              "began: another version of ecs-eco reads it, or its code has changed")
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
        return load(Document(self.content["config"], SWEEP, home, places=[self.folder / CODE]))  # type: ignore[arg-type]


def read_sweep(folder: str | Path) -> Sweep:
    """Return the sweep in a folder. Raises RecordingError where there is none, or it is damaged."""
    path = Path(folder) / SWEEP
    try:
        status = path.stat()
        return _read(Path(os.path.abspath(folder)), status.st_mtime_ns, status.st_size)
    except FileNotFoundError:
        raise RecordingError(f"{folder} is no folder of a sweep: it has no {SWEEP} "
                             "(a folder written by `ecs-eco sweep`)") from None
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise RecordingError(f"{path}: is damaged: {error}") from None


@lru_cache(maxsize=4)
def _read(folder: Path, written: int, size: int) -> Sweep:
    content = json.loads((folder / SWEEP).read_text(encoding="utf-8"))
    sweep = Sweep(folder, content)
    if content["format"] != FORMAT:
        raise ValueError(f"it has the format {content['format']}, and this version reads {FORMAT}")
    assert sweep.jobs is not None
    assert sweep.trainings is not None
    return sweep


def has_sweep(folder: Path) -> bool:
    """Return whether a sweep was begun in a folder."""
    return os.path.isfile(folder / SWEEP)


def begin(folder: Path, design: Design) -> Sweep:
    """Write the sweep of a design into a folder, or find it there; return it.

    Raises ForeignFile where the folder holds the sweep of another plan.
    """
    if has_sweep(folder):
        sweep = read_sweep(folder)
        check_plan(sweep, design)
        return sweep
    folder.mkdir(parents=True, exist_ok=True)
    keep_copies(sources(design.base), folder)
    home = _keep_policies(folder, design)
    write_json(folder / SWEEP, {
        "format": FORMAT, "hash": design.hash, "world": design.base.name,
        "title": design.file.plan.title or design.base.title, "source": design.file.document.source,
        "ticks": design.ticks, "checkpoint_every": design.file.plan.checkpoint_every,
        "plan": design.settings, "mode": portable.mode(), "home": str(home), "config": design.base.resolved(),
        "code": noted(sources(design.base)),
        "trainings": [as_json(one) for one in design.trainings],
        "jobs": [as_json(job) for job in design.jobs],
    })  # fmt: skip
    return read_sweep(folder)


def check_plan(sweep: Sweep, design: Design) -> None:
    """Raise ForeignFile where a sweep is that of another plan."""
    if sweep.hash == design.hash:
        sweep.check_mode()
        return
    before, now = sweep.content["plan"], design.settings
    different = [key for key in {**before, **now} if before.get(key) != now.get(key)] or ["its worlds"]
    raise ForeignFile(
        f"{sweep.folder / SWEEP}: holds the sweep of another plan: {', '.join(different)} "
        f"differ{'s' * (len(different) == 1)}; name another folder with --out, or go on with what is there: "
        f"ecs-eco sweep resume {sweep.folder}"
    )


def _keep_policies(folder: Path, design: Design) -> Path:
    """Copy the policies that the world and the plan name; return the folder, within the sweep's, that stands
    for the world's own."""
    config = design.base
    files = [s.policy.file for s in config.species.values() if s.policy.file is not None]
    inside = [file for file in files if not os.path.isabs(file)]
    ups = max([Path(os.path.normpath(file)).parts.count("..") for file in inside], default=0)
    home = Path("world", *["below"] * ups)  # so deep that what lies above the world's folder is copied too
    for file in inside:
        if config.file(file).is_file():
            copy = folder / os.path.normpath(home / file)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(config.file(file), copy)
    (folder / home).mkdir(parents=True, exist_ok=True)
    given = plan_folder(design.file)
    for name in species_with_policy(config) if given is not None else ():
        (folder / "policies" / GIVEN).mkdir(parents=True, exist_ok=True)
        shutil.copyfile(given / f"{name}.safetensors",  # type: ignore[operator]
                        folder / "policies" / GIVEN / f"{name}.safetensors")
    return home
