"""Commands that run and resume archipelagos."""

from __future__ import annotations

from pathlib import Path

import typer

from ecs_eco.cli.folders import results
from ecs_eco.cli.terminal import INTERRUPTED, Progress, complain, progress, refuse, say
from ecs_eco.config import WorldConfig
from ecs_eco.lab.archipelago import Archipelago
from ecs_eco.record.claim import Claim

UNIT = "ticks of islands"


def run_islands(
    config: WorldConfig,
    seed: int,
    ticks: int,
    out: Path | None,
    quiet: bool,
    threads: int,
    learn: bool | None,
    policies: str,
    report: bool,
    record: str | None,
    workers: int | None,
    on: str,
    command: str,
) -> None:
    """Run a world with [archipelago] into a folder, with a run folder for each island in it."""
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
    """Resume an archipelago from its last barrier."""
    if forks:
        refuse(
            "DIR",
            "is an archipelago, which cannot be forked as a whole",
            str(folder),
            "one of its islands, which then continues alone: DIR/islands/NAME",
        )
    made = Archipelago(folder)
    with progress(folder.name, quiet, UNIT) as bar:
        _go(made, until, workers, on, bar, threads, report, None)


def _go(
    made: Archipelago,
    until: int | None,
    workers: int | None,
    on: str,
    bar: Progress,
    threads: int,
    report: bool,
    claim: Claim | None,
) -> None:
    try:
        manifest = made.run(until, workers, on, progress=bar, threads=threads, report=report, claim=claim)
    except KeyboardInterrupt:
        complain(
            f"Stopped; all islands are at tick {made.tick} of {made.manifest['ticks']}; continue with: "
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
