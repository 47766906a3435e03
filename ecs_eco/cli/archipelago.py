"""Running and resuming archipelagos."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import typer

from ecs_eco.cli.folders import known_policies, results
from ecs_eco.cli.terminal import INTERRUPTED, complain, progress, refuse, say
from ecs_eco.compiled import portable
from ecs_eco.experiments.engines import LOCAL, check_engine

UNIT = "ticks of islands"


def command_of(
    world: str,
    config: Any,
    seed: int,
    ticks: int,
    policies: str,
    changes: list[str],
    learn: bool | None,
    record: str | None,
) -> str:
    """Return the command that runs a world so, as its manifest has it."""
    command = (
        f"ecs-eco{portable.option()} run {shlex.quote(world)} --seed {seed} "
        f"--ticks {ticks} --policies {shlex.quote(policies)}"
    )
    command += " --trust" if config.code else ""
    command += "".join(f" --set {shlex.quote(change)}" for change in changes)
    command += {None: "", True: " --learn", False: " --no-learn"}[learn] + " --out DIR"
    return command + ("" if record is None else f" --record {record}")


def has_islands(config: Any, world: str, alive: bool, workers: int | None, on: str) -> bool:
    """Return whether a world is to be run as an archipelago; refuses options of the one kind for the other.
    `alive`: whether it is to be watched, or to have checkpoints of its own."""
    islands = config.archipelago is not None and config.archipelago.here is None
    if islands and alive:
        refuse(
            "WORLD",
            "has islands: they have checkpoints at barriers, and are watched once recorded",
            world,
            "no --watch and no --checkpoint-every",
        )
    if not islands and (workers is not None or on != LOCAL):
        source, value = ("--on", on) if workers is None else ("--workers", workers)
        refuse(source, "is for islands, and this world has no [archipelago]", value, "none")
    return islands


def run_islands(
    config: Any,
    world: str,
    changes: list[str],
    ticks: int | None,
    seed: int | None,
    out: Path | None,
    quiet: bool,
    threads: int,
    learn: bool | None,
    policies: str,
    report: bool,
    record: str | None,
    workers: int | None,
    on: str,
) -> None:
    """Run a world with [archipelago] into a folder, with a run folder for each island in it."""
    check_engine(on)
    seed, ticks = config.seed if seed is None else seed, ticks or config.ticks
    known_policies(policies, config)
    from ecs_eco.archipelago.run import Archipelago

    command = command_of(world, config, seed, ticks, policies, changes, learn, record)
    with results(out, f"{config.name}-{seed}") as claim, progress(config.name, quiet, UNIT) as bar:
        made = Archipelago.from_config(
            config, seed, ticks, claim, policies, learn, record=record, command=command
        )
        _go(made, None, workers, on, bar, threads, report, claim)


def resume_islands(
    folder: Path,
    until: int | None,
    forks: bool,
    quiet: bool,
    threads: int,
    report: bool,
    workers: int | None,
    on: str,
) -> None:
    """Go on with an archipelago from its last barrier."""
    from ecs_eco.archipelago.run import Archipelago

    if forks:
        refuse(
            "DIR",
            "is an archipelago, which cannot be forked as a whole",
            str(folder),
            "one of its islands, which goes on by itself: DIR/islands/NAME",
        )
    made = Archipelago(folder)
    with progress(folder.name, quiet, UNIT) as bar:
        _go(made, until, workers, on, bar, threads, report, None)


def _go(
    made: Any,
    until: int | None,
    workers: int | None,
    on: str,
    bar: Any,
    threads: int,
    report: bool,
    claim: Any,
) -> None:
    try:
        manifest = made.run(until, workers, on, progress=bar, threads=threads, report=report, claim=claim)
    except KeyboardInterrupt:
        complain(
            f"Stopped; all islands are at tick {made.tick} of {made.manifest['ticks']}; go on with: "
            f"ecs-eco resume {made.folder}."
        )
        raise typer.Exit(INTERRUPTED) from None
    lines = [
        f"{manifest['tick']} ticks of {manifest['world']} on {len(made.islands)} islands, seed "
        f"{manifest['seed']}, in {made.folder}",
        f"  digest {manifest['digest'][:16]}",
    ]
    lines += [
        f"  {name}: " + ", ".join(f"{n} {species}" for species, n in state["n"].items())
        for name, state in manifest["islands"].items()
    ]
    say("\n".join(lines))


def refuse_islands(folder: Path) -> None:
    """Refuse the folder of an archipelago where a run is needed."""
    from ecs_eco.record.archipelago import is_archipelago, read

    if is_archipelago(folder):
        names = list(read(folder)["config"]["archipelago"]["islands"])
        refuse(
            "DIR",
            "is an archipelago; name one of its islands",
            str(folder),
            f"a run folder, as {folder}/islands/{names[0]}",
        )
