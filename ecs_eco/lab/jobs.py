"""One job of a sweep, the run of an arm in a folder, and the training of policies. Any engine can call each
repeatedly: it starts the work, resumes it, or returns its result."""

import json
import math
import os
import socket
import time
import traceback
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, ConfigDict

from ecs_eco.analysis.compare import clean
from ecs_eco.analysis.cycles import cycle_statistics
from ecs_eco.analysis.extinction import lifetime
from ecs_eco.analysis.measures import course, measured, run_mean
from ecs_eco.analysis.runs import DIED, load_series
from ecs_eco.compiled import portable
from ecs_eco.config import WorldConfig
from ecs_eco.engine.errors import ForeignFile, RecordingError
from ecs_eco.engine.files import write, write_json
from ecs_eco.inputs.section import Section
from ecs_eco.inputs.trust import allow
from ecs_eco.lab.design import Job
from ecs_eco.lab.folder import DONE, FAILED, PROGRESS, RUN, Sweep, read_sweep
from ecs_eco.lab.pool import PATIENCE, finishing, once_free
from ecs_eco.lab.treatments import Arm, species_with_policy
from ecs_eco.learning.weights import hash_of
from ecs_eco.record import checkpoint
from ecs_eco.record.claim import Claim, ours
from ecs_eco.record.container import inside, remove
from ecs_eco.record.manifest import Seed, Sha, Tick
from ecs_eco.record.seal import read_manifest, read_sealed, write_manifest
from ecs_eco.worlds.policies import weights_files

PACE = 1.0  # [s] between records of a job's progress
BOOTSTRAPS = 99  # for the p value of a period; cycles in single runs are reported at p ≤ 0.05
TRAINING = "training.json"
TRAINED = (TRAINING, "*.safetensors")  # files of a training run
EVERY = 2_000  # minimum number of ticks between the checkpoints of a run
UNFINISHED = 75  # exit code of a process that was asked to stop and left a checkpoint: EX_TEMPFAIL


def run_job(folder: str | Path, number: int, allowed: Collection[str] = ()) -> dict[str, Any]:
    """Run one job of a sweep and return the contents of its done.json.

    A stopped job resumes from its last checkpoint. Policies that the job needs are trained first.

    Parameters
    ----------
    folder : str or Path
        Folder of the sweep.
    number : int
        Job number.
    allowed : collection of str
        Hashes of code that is allowed to run.

    Returns
    -------
    dict

    Raises
    ------
    FolderInUse
        If another process is running the job.
    Exception
        Any error raised by the run; failed.json then describes it.

    Examples
    --------
    >>> from ecs_eco.lab import run_job, run_sweep
    >>> plan = {"world": "predator-prey", "ticks": 10, "grid": {"species.deer.metabolism.basal": [0.004]}}
    >>> outcome = run_sweep(plan, "swept", workers=1)
    >>> "digest" in run_job("swept", 0)
    True
    """
    sweep = _opened(folder, allowed)
    place = inside(sweep.folder, sweep.job_folder(number))
    job = sweep.jobs[number]
    if (done := read_done(sweep, number)) is not None:
        return done
    place.mkdir(parents=True, exist_ok=True)
    with once_free(lambda: Claim(place), PATIENCE, PACE):
        if (done := read_done(sweep, number)) is not None:
            return done
        begin = time.time()
        try:
            done = _do(sweep, job, place) | {"began": begin}
        except Exception as error:
            failure = {
                "error": type(error).__name__,
                "text": str(error),
                "at": time.time(),
                "host": socket.gethostname(),
                "trace": traceback.format_exc()[-4000:],
            }
            write_json(place / FAILED, failure)
            raise
        write_manifest(place, done, DONE)
        for name in (FAILED, PROGRESS):
            (place / name).unlink(missing_ok=True)
        return done


def train(folder: str | Path, name: str, allowed: Collection[str] = ()) -> str:
    """Train the policies of one of a sweep's training runs unless they exist, after waiting for any process that
    is training them; return their folder."""
    place, config, seed = _opened(folder, allowed).training(name)
    if not is_trained(place, config, seed):
        with once_free(lambda: ours(place.with_name(f"{place.name}.training")), math.inf, PACE):
            train_or_find(place, config, seed)
    return str(place)


Number = Annotated[  # no integer that a table cannot store
    float, BeforeValidator(lambda v: "" if isinstance(v, int) and abs(v) >= 2**63 else v)
]


class Numbers(Section):
    """Results for one species in a run."""

    model_config = ConfigDict(extra="allow", strict=True)
    __pydantic_extra__: dict[str, Number | None]

    deaths: dict[str, Number]


class Summary(Section):
    """Results of a run, as returned by `summary_of`."""

    persisted: bool
    lived: Number
    species: dict[str, Numbers]
    reporters: dict[str, dict[str, dict[str, Number | None]]]


class Done(Section):
    """The contents of done.json."""

    format: Literal[1]
    number: int
    sweep: Sha
    values: dict[str, Any]
    treatment: str
    training_seed: Seed | None
    world_seed: Seed
    config_hash: Sha
    digest: Sha
    ticks: Tick
    git_commit: str | None
    versions: dict[str, str]
    weights: dict[str, str]
    ended_by: dict[str, Any] | None = None  # condition and tick
    seconds: Number
    began: float
    ended: float
    host: str
    summary: Summary


def read_done(sweep: Sweep, number: int) -> dict[str, Any] | None:
    """Return the contents of a job's done.json, or None if the job is not done. Raises ForeignFile if the file
    belongs to another job, RecordingError if it is damaged."""
    path = sweep.job_folder(number) / DONE
    if not path.exists():
        return None
    try:
        done = read_sealed(path.parent, DONE, Done)
    except RecordingError as error:
        raise RecordingError(f"{error}; remove this file; the job will then find its run") from None
    job = sweep.jobs[number]
    if different := [key for key, value in _identity(sweep, job).items() if done[key] != value]:
        raise ForeignFile(
            f"{path}: belongs to another job ({', '.join(different)}), not to {job}; remove its folder"
        )
    return done


def _identity(sweep: Sweep, job: Job) -> dict[str, Any]:
    return {
        "number": job.number,
        "sweep": sweep.hash,
        "values": job.values,
        "treatment": job.treatment,
        "training_seed": job.training_seed,
        "world_seed": job.world_seed,
        "config_hash": job.config_hash,
        "ticks": sweep.ticks,
    }


def _do(sweep: Sweep, job: Job, place: Path) -> dict[str, Any]:
    note = _noting(place / PROGRESS, sweep.ticks)
    checkpoints = (place / RUN / "checkpoints").glob(f"tick-*{checkpoint.SUFFIX}")
    note(max(map(checkpoint.tick_of, checkpoints), default=0), sweep.ticks)
    if job.training is not None:
        train(sweep.folder, job.training)
    arm = sweep.arm(job)
    arm.config._code.require(sweep.content["source"])
    if not has_run(arm, job.world_seed, sweep.ticks, place / RUN):
        every, rules = sweep.content["checkpoint_every"], sweep.content["plan"].get("until", [])
        run_arm(arm, job.world_seed, sweep.ticks, place / RUN, every, note, rules)
    manifest = read_manifest(place / RUN)
    return _identity(sweep, job) | {
        "format": 1,
        "digest": manifest["digest"],
        "git_commit": manifest["git_commit"],
        "versions": manifest["versions"],
        "weights": manifest["weights"],
        "ended_by": manifest.get("ended"),
        "seconds": round(manifest["wall_seconds"], 3),
        "ended": time.time(),
        "host": socket.gethostname(),
        "summary": summary_of(place / RUN, sweep.content["plan"].get("from_tick", 0)),
    }


def summary_of(run: Path, from_tick: int = 0) -> dict[str, Any]:
    """Summarize a run folder as JSON, with times in ticks. Means, cycles, births and deaths are computed from
    `from_tick` on, extinctions over the whole run."""
    whole = load_series(run)
    late = whole.ticks >= from_tick
    series = replace(whole, ticks=whole.ticks[late], columns={k: v[late] for k, v in whole.columns.items()})
    cycles = cycle_statistics(series, n_boot=BOOTSTRAPS)
    cycling = cycles.cycling() if cycles.enough else ()
    lived, _ = lifetime(whole)
    species = {}
    for i, name in enumerate(series.species):
        peak = cycles.peaks.get(name)
        species[name] = {
            "mean": series.n[:, i].mean() if late.any() else np.nan,
            "final": whole.n[-1, i],
            "extinct": whole.extinct[i],
            "period": peak.period if peak is not None and name in cycling else np.nan,
            "period_p": peak.p if peak is not None else np.nan,
            "deaths": {c: n for c in series.causes if (n := series.columns[DIED + c][:, i].sum())},
        }
        if "births" in series.columns:
            species[name]["births"] = series.columns["births"][:, i].sum()
    return dict(
        clean(
            {
                "persisted": whole.persisted,
                "lived": lived,
                "species": species,
                "reporters": {
                    what: {
                        of: {"mean": run_mean(series, what, of), "final": course(whole, what, of)[-1]}
                        for of in kinds
                    }
                    for what, kinds in measured(whole).items()
                },
            }
        )
    )


def _opened(folder: str | Path, allowed: Collection[str]) -> Sweep:
    allow(allowed)
    sweep = read_sweep(folder)
    sweep.may_continue()
    return sweep


def _noting(path: Path, ticks: int) -> Callable[[int, int], None]:
    """Return a progress function that writes the current tick and the time of the first tick to a file."""
    last = 0.0
    begin: dict[str, Any] = {"pid": os.getpid(), "host": socket.gethostname(), "ticks": ticks}

    def note(done: int, _: int) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last < PACE and last:
            return
        if last:  # ticks are running; earlier training and compiling do not affect their rate
            begin.setdefault("from", done)
            begin.setdefault("began", time.time())
        last = now
        with suppress(OSError):
            write(path, json.dumps(begin | {"done": done, "at": time.time()}))

    return note


def run_arm(
    arm: Arm,
    seed: int,
    ticks: int,
    folder: Path,
    every: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    until: Sequence[str] = (),
) -> dict[str, Any]:
    """Run an arm in a folder, with a checkpoint every `every` ticks, until a condition is true or all ticks are
    done; return its manifest. A stopped run resumes from its checkpoint, or restarts without one; nothing is
    removed. Raises FolderInUse, ForeignFile if the folder contains another run's files, and RecordingError or
    CheckpointError for a damaged file."""
    from ecs_eco.runs.run import resume, run_to_folder

    if every is None and ticks > EVERY:
        every = max(EVERY, ticks // 20)
    with finishing():
        arm.config._code.pass_on()
        if (folder / "manifest.json").is_file():
            check_run(folder, read_manifest(folder), arm, seed)
            return resume(folder, ticks, progress, report=False, complain=lambda _: None)
        return run_to_folder(
            arm.config,
            seed=seed,
            ticks=ticks,
            out=folder,
            policies=arm.policies,
            learn=arm.learn,
            controls=arm.controls,
            progress=progress,
            report=False,
            checkpoint_every=every,
            keep=1,
            until=until,
        )


def has_run(arm: Arm, seed: int, ticks: int, folder: Path) -> bool:
    """Return whether a folder contains a run of this length, or one that a condition ended. Raises errors as
    `check_run` does, and RecordingError if its manifest is damaged."""
    try:
        manifest = read_manifest(folder)
    except FileNotFoundError:
        return False
    check_run(folder, manifest, arm, seed)
    return bool(manifest.get("finished") and (manifest.get("ended") or manifest.get("done", 0) >= ticks))


def check_run(folder: Path, manifest: dict[str, Any], arm: Arm, seed: int) -> None:
    """Raise ForeignFile if the run in a folder belongs to another arm, seed or mode, or is a fork."""
    from ecs_eco.runs.begin import policies_as_json

    weights = {name: hash_of(file) for name, file in weights_files(arm.config, arm.policies).items()}
    wanted = {
        "config_hash": arm.config.config_hash,
        "seed": seed,
        "learn": arm.learn,
        "controls": list(arm.controls),
        "weights": weights,
    }
    if not weights:  # the folder may have been moved
        wanted["policies"] = policies_as_json(arm.policies)
    different = [key for key, value in wanted.items() if manifest.get(key) != value]
    if "forked" in manifest:
        different.append("forked")
    if different:
        shown = ", ".join(f"{key} {manifest.get(key)}" if key == "seed" else key for key in different)
        raise ForeignFile(
            f"{folder / 'manifest.json'}: belongs to another run ({shown}), not to {arm.name}, seed {seed}; "
            "remove the folder, or choose another with --out"
        )
    if why := portable.other_mode(manifest):
        raise ForeignFile(f"{folder / 'manifest.json'}: {why}")


def train_or_find(
    folder: Path, config: WorldConfig, seed: int, ticks: int | None = None, *, verify: bool = True
) -> Path:
    """Return the folder with <species>.safetensors and training.json, after training if necessary. It appears
    only when complete. Of several processes that train the same policies at once, the first keeps its result;
    all are identical. Without `verify`, any training run is accepted, because the folder's name identifies
    it. Raises ForeignFile if the folder contains another training run, RecordingError if it is damaged or
    contains other files; only leftovers of a killed training run are removed."""
    from ecs_eco.lab.pretraining import pretrain

    if is_trained(folder, config, seed, ticks, verify=verify):
        return folder
    part = folder.with_name(f"{folder.name}.{os.getpid()}.part")
    if not remove(part, TRAINED):
        raise RecordingError(
            f"{part}: is a link, or contains files that no training run writes; move it away"
        )
    with finishing():
        try:
            pretrain(config, seed=seed, ticks=ticks, out=part)
            if not is_trained(folder, config, seed, ticks, verify=verify):
                if not remove(folder, TRAINED):
                    raise RecordingError(
                        f"{folder}: has no {TRAINING}, but contains files that no training run writes; move them "
                        "away, or choose another folder"
                    )
                try:
                    part.rename(folder)
                except OSError:  # another process was faster
                    if not (folder / TRAINING).is_file():
                        raise
        finally:
            remove(part, TRAINED)
    return folder


def is_trained(
    folder: Path, config: WorldConfig, seed: int, ticks: int | None = None, *, verify: bool = True
) -> bool:
    """Return whether a folder contains this training run. Raises ForeignFile if it contains another training
    run, RecordingError if it is damaged."""
    path = folder / TRAINING
    if not verify or not path.is_file():
        return path.is_file()
    wanted = {"config_hash": config.config_hash, "seed": seed} | ({} if ticks is None else {"ticks": ticks})
    training = read_manifest(folder, TRAINING)
    different = [key for key in wanted if training.get(key) != wanted[key]]
    if different:
        there, here = (
            ", ".join(f"{key} {values.get(key)}" for key in different) for values in (training, wanted)
        )
        raise ForeignFile(f"{path}: belongs to another training run: {there}, not {here}")
    hashes = training.get("weights")
    for name in species_with_policy(config):
        file = folder / f"{name}.safetensors"
        if not file.is_file():
            raise RecordingError(f"{file}: is missing; remove its folder to train again")
        if not isinstance(hashes, dict) or hashes.get(name) != hash_of(file):
            raise ForeignFile(f"{file}: is not the policy written by this training run")
    return True


def forget_trained(folder: Path) -> None:
    """Remove all training runs in a folder, and the folder if nothing else is left."""
    for place in folder.glob("training-*"):
        remove(place, TRAINED)
    remove(folder, ())
