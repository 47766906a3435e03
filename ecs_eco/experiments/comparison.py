"""compare: a world and its controls, each run with the same seeds in processes of one thread; the same command goes on with it."""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import re
import signal
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer

from ecs_eco.cli.terminal import INTERRUPTED, complain, printable, progress, refuse, say
from ecs_eco.config import WorldConfig, load
from ecs_eco.engine.errors import nearest
from ecs_eco.experiments import seed_grid as crossing
from ecs_eco.experiments import variants
from ecs_eco.experiments.workers import end_with_parent, one_thread_each

CONTROLS = {"random-policy": "random", "untrained-policy": "untrained"}  # by the policies that they run with
LEARNING = {"learning": True, "frozen-learning": False}  # by whether policies go on learning in the run
TAKEN = {  # by what is taken from the world, and what a world without it lacks
    "no-reflexes": "a reflex", "neutral-drift": "a genome", "shuffled-genome": "a genome", "no-mutation": "a genome",
}  # fmt: skip
LONGEST_NAME = 100  # bytes; files in these folders have names of their own, and systems end at 255 for one
EVERY = 2_000  # least ticks between the checkpoints of a run


@dataclass(frozen=True)
class Arm:
    """One side of a comparison."""

    name: str
    config: WorldConfig
    policies: Any = "trained"  # or a dict: species → policies
    learn: bool | None = None  # None: as the world says
    controls: tuple[str, ...] = ()  # of ecs_eco.worlds.treatments
    variant: bool = False  # one of ecs_eco.experiments.variants


def compare_arms(
    world: str,
    changes: list[str],
    controls: list[str],
    seeds: int,
    ticks: int | None,
    workers: int,
    out: Path | None,
    quiet: bool,
    training_seeds: int | None = None,
    retrain: bool = False,
) -> None:
    """Run all arms with all seeds, and write and say what differs."""
    arms = arms_of(world, changes, controls)
    crossing.check_training(arms, controls, training_seeds, retrain)
    config = arms[0].config
    ticks = ticks or config.ticks
    plan = crossing.plan_of(arms, ticks, training_seeds is not None, retrain)
    with crossing.folder_of(out, f"{config.name}-compare", plan) as claim:
        out = claim.path
        crossing.write_plan(out, plan)
        worlds = range(1, seeds + 1)
        if training_seeds is not None:
            _cross(out, arms, range(1, training_seeds + 1), worlds, ticks, workers, quiet, retrain)
            return
        jobs = {(arm.name, seed): (arm, seed, ticks, out / arm.name / f"seed-{seed}") for arm in arms for seed in worlds}
        finish(jobs, workers, quiet, out)
        runs = {arm.name: [jobs[arm.name, seed][3] for seed in worlds] for arm in arms}
        tell(out, runs, policies={arm.name: crossing.told_bundled(arm, arms) for arm in arms if crossing.thinkers(arm.config)})


def _cross(out: Path, arms: list[Arm], training: range, worlds: range, ticks: int, workers: int, quiet: bool, retrain: bool) -> None:
    """Train once for each training seed, run each policy on every world seed, and tell."""
    places = {arm.name: crossing.policies_folder(out, arm, arms, retrain) for arm in arms if crossing.learnt(arm)}
    owners = {places[arm.name]: arm for arm in reversed(arms) if arm.name in places}
    wanted = {(str(place.name), k): (arm.config, k, place / f"seed-{k}") for place, arm in owners.items() for k in training}
    missing = {key: job for key, job in wanted.items() if not crossing.trained_already(job[2], job[0], job[1])}
    if len(run_all(missing, workers, quiet, crossing.train_one, "training", "policies", out)) < len(missing):
        complain(f"Not all policies could be trained; those that are there are in {out / 'policies'}.")
        raise typer.Exit(1)
    jobs: dict[tuple[str, Any], tuple[Any, ...]] = {}
    seeds: dict[str, list[int]] = {}
    for arm in arms:
        for k in training if arm.name in places else range(1):
            runs, where = (crossing.with_policies(arm, places[arm.name] / f"seed-{k}"), f"training-{k}") if k else (arm, ".")
            for w in worlds:
                jobs[arm.name, f"{w}, training seed {k}" if k else w] = (runs, w, ticks, out / arm.name / where / f"seed-{w}")
                seeds.setdefault(arm.name, []).append(k)
    finish(jobs, workers, quiet, out)
    runs_of = {arm.name: [job[3] for (name, _), job in jobs.items() if name == arm.name] for arm in arms}
    words = {arm.name: crossing.told(arm, arms, len(training), retrain) for arm in arms}
    tell(out, runs_of, {name: seeds[name] for name in places}, words)


def finish(jobs: Mapping[tuple[str, Any], tuple[Any, ...]], workers: int, quiet: bool, out: Path) -> None:
    """Run what is not there yet; ends the command where a run failed."""
    missing = {name: job for name, job in jobs.items() if not crossing.ran_already(job[3], job[2], job[0], job[1])}
    if len(missing) < len(jobs) and not quiet:
        complain(f"{len(jobs) - len(missing)} of {len(jobs)} runs are there already.")
    done = run_all(missing, workers, quiet, out=out)
    if len(done) < len(missing):
        complain(f"{len(missing) - len(done)} of {len(jobs)} runs failed; what the others recorded is in {out}.")
        raise typer.Exit(1)


def arms_of(world: str, changes: list[str], controls: list[str]) -> list[Arm]:
    """The world as it is and one arm for each control; raises ConfigError.

    A control is a name (`random-policy`; `random-policy:deer` for one species alone; `learning`, `frozen-learning`;
    `no-reflexes`, `neutral-drift`, `shuffled-genome`, `no-mutation`; those of `ecs_eco.experiments.variants`) or a value changed
    (`species.deer.count=50`).
    """
    arms = [Arm("world", load(world, changes))]
    for control in controls:
        name = folder_name(control)
        kind, _, species = control.partition(":")
        thinkers = [n for n, s in arms[0].config.species.items() if s.policy.kind != "none"]
        if kind in CONTROLS and species in thinkers:
            arm = Arm(name, arms[0].config, {species: CONTROLS[kind]})
        elif control in CONTROLS:
            arm = Arm(name, arms[0].config, CONTROLS[control])
        elif control in LEARNING:
            arm = Arm(name, arms[0].config, learn=LEARNING[control])
        elif control in TAKEN:
            if not _has(arms[0].config, control):
                refuse("--control", f"no species has {TAKEN[control]}", control, "a control that takes something away")
            arm = Arm(name, arms[0].config, controls=(control,))
        elif control in variants.names(arms[0].config):
            arm = Arm(name, _variant(arms[0].config, control), variant=True)
        elif "=" in control:
            arm = Arm(name, load(world, [*changes, control]))
        elif kind in CONTROLS:
            refuse("--control", "no such species with a policy", species, ", ".join(thinkers) or "none", nearest(species, thinkers))
        else:
            names = [*CONTROLS, *LEARNING, *TAKEN, *variants.names(arms[0].config)]
            allowed = f"{', '.join(names)}, one of the first two for a single species (random-policy:NAME), or a value: key=value"
            refuse("--control", "no such control", control, allowed, nearest(control, names))
        if any(a.name == name for a in arms):
            refuse("--control", "named twice", control, "each control once")
        arms.append(arm)
    if any(a.policies == "random" for a in arms) and not any(
        s.policy.kind != "none" for s in arms[0].config.species.values()
    ):
        refuse("--control", "no species has a policy", "random-policy", "a changed value: key=value")
    return arms


def folder_name(control: str) -> str:
    """The folder of a control's runs: its letters, digits, dots and hyphens; of a long one the first, and a hash."""
    name = re.sub(r"[^\w.-]+", "-", control.strip()).strip("-.")
    if len(name.encode()) <= LONGEST_NAME:
        return name
    return f"{name.encode()[: LONGEST_NAME - 9].decode(errors='ignore')}-{hashlib.sha256(control.encode()).hexdigest()[:8]}"


def _variant(config: WorldConfig, name: str) -> WorldConfig:
    """The world as a variant changes it; ConfigError where it has nothing for it."""
    try:
        return load(config, variants.variant(config, name))
    except variants.NotApplicable as error:
        refuse("--control", error.what, name, error.allowed)


def _has(config: WorldConfig, control: str) -> bool:
    """Whether any species has what a control takes away."""
    if control == "no-reflexes":
        return any(s.reflex is not None for s in config.species.values())
    return any(s.genome is not None or s.policy.inherit == "learned" for s in config.species.values())


def run_all(
    jobs: Mapping[tuple[str, Any], tuple[Any, ...]],
    workers: int,
    quiet: bool,
    work: Callable[..., Any] | None = None,
    word: str = "comparing",
    unit: str = "runs",
    out: Path | None = None,
) -> dict[tuple[str, Any], Any]:
    """What the jobs that succeeded returned, by arm and seed; says why the others did not. `work` is `run_one` where absent."""
    done: dict[tuple[str, Any], Any] = {}
    if not jobs:
        return done
    context, n = multiprocessing.get_context("spawn"), min(workers, len(jobs))
    with one_thread_each(), ProcessPoolExecutor(n, context, initializer=_obey) as pool:
        futures: dict[Future[Any], tuple[str, Any]] = {pool.submit(work or run_one, *job): name for name, job in jobs.items()}
        try:
            with progress(word, quiet, unit) as bar:
                bar(0, len(jobs))
                for future in as_completed(futures):
                    arm, seed = futures[future]
                    if isinstance(error := future.exception(), BrokenProcessPool):
                        complain(f"A worker process was killed from outside (out of memory?): the {unit} that it and the others had not "
                                 "finished are lost; those done are whole.")  # fmt: skip
                        break
                    if error:
                        complain(f"{arm}, seed {seed}: {type(error).__name__}: {error}")
                    else:
                        done[arm, seed] = future.result()
                    bar(len(done), len(jobs))
        except KeyboardInterrupt:
            for process in multiprocessing.active_children():
                process.terminate()
            pool.shutdown(cancel_futures=True)
            folder = out or next(iter(jobs.values()))[3].parent.parent
            again = f"; the same command with --out {folder} goes on with it" if out else ""
            complain(f"Stopped after {len(done)} of {len(jobs)} {unit}; what was recorded until then is in {folder}{again}.")
            raise typer.Exit(INTERRUPTED) from None
    return done


_running = False  # in a worker: whether a run is to be finished off before the process ends


def _obey() -> None:
    """A worker leaves Ctrl-C to its parent, and ends once when told, after writing what it recorded."""

    def end(*_: object) -> None:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        if not _running:
            os._exit(INTERRUPTED)
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, end)
    end_with_parent()


def run_one(arm: Arm, seed: int, ticks: int, out: Path) -> Any:
    """One run, in a process of its own; one that was stopped goes on from its checkpoint, or begins anew where it has none."""
    global _running
    from ecs_eco.engine.errors import CheckpointError, FolderInUse, ForeignFile, RecordingError
    from ecs_eco.record import resume, run_to_folder
    from ecs_eco.record.folder import remove_run

    every = max(EVERY, ticks // 20) if ticks > EVERY else None
    _running = True
    arm.config._code.pass_on()
    try:
        if (out / "manifest.json").is_file():
            try:
                return resume(out, ticks, report=False, complain=lambda _: None)
            except (FolderInUse, ForeignFile):
                raise
            except (CheckpointError, RecordingError):
                remove_run(out)
        return run_to_folder(arm.config, seed=seed, ticks=ticks, out=out, policies=arm.policies, learn=arm.learn, controls=arm.controls,
                             report=False, checkpoint_every=every, keep=1)
    except KeyboardInterrupt:
        os._exit(INTERRUPTED)
    finally:
        _running = False


def tell(
    out: Path, runs: dict[str, list[Path]], training: dict[str, list[int]] | None = None, policies: dict[str, str] | None = None
) -> None:
    """Compare the arms, write the comparison, and say it: first in how many runs all persisted, then a table."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Column, Table

    from ecs_eco.analysis.compare import compare

    found = compare(runs, out, training=training, policies=policies)
    for name, text in found["opening"].items():
        say(f"{name}: {text}")
    for name, words in (policies or {}).items():
        say(f"  {name} runs with {words}")
    for name, arm in found["arms"].items():
        if "crossed" in arm:
            _, low, high = arm["persistence"]
            say(f"  {name}: share that persists, over both kinds of seeds: 95 % interval {low:.0%} to {high:.0%}")
            shares = arm["crossed"]["variance_shares"].get("persisted")
            if shares and shares["share"]["rest"][0] is not None:
                parts = ", ".join(f"{effect} {share[0]:.0%}" for effect, share in shares["share"].items())
                say(f"  {name}: whence the variance of persisting comes: {parts}")
    for name, arm in found["arms"].items():
        for species, row in arm["per_species"].items():
            if d := row.get("depth"):
                r = "" if d["r"] is None else f", correlation with light {d['r'][0]:.2f}"
                say(f"  {name}: depth of {species} over the day, means of {d['n']} runs: amplitude {d['amplitude'][0]:.0%} of the water, "
                    f"{d['along_day'][0]:+.0%} along the sun{r}")  # fmt: skip
    head = ("arm", "runs", "all persist", "species", "mean number", "died out in")
    table = Table(*(Column(word, overflow="fold", no_wrap=word in ("arm", "species")) for word in head))
    for name, arm in found["arms"].items():
        first = [escape(printable(name)), str(arm["n"]), str(arm["persisted"])]
        for species, row in arm["per_species"].items():
            table.add_row(*first, escape(printable(species)), f"{row['mean_number']:.1f}", str(row["extinctions"]))
            first = ["", "", ""]
    Console().print(table)
    say(f"written: {out / 'compare.html'}")
