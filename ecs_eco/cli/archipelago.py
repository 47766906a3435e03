"""Commands that run and resume archipelagos."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer

from ecs_eco.cli.folders import results
from ecs_eco.cli.options import How
from ecs_eco.cli.terminal import INTERRUPTED, complain, progress, refuse, say
from ecs_eco.config import WorldConfig
from ecs_eco.lab.archipelago import Archipelago


def run_islands(
    config: WorldConfig,
    seed: int,
    ticks: int,
    out: Path | None,
    policies: str,
    learn: bool | None,
    how: How,
    **more: Any,
) -> None:
    """Run a world with [archipelago] into a folder, with a run folder for each island in it."""
    with results(out, f"{config.name}-{seed}") as claim:
        made = Archipelago.from_config(config, seed, ticks, claim, policies, learn, **more)
        _go(made, config.name, how, claim=claim)


def resume_islands(folder: Path, until: int | None, forks: bool, how: How) -> None:
    """Resume an archipelago from its last barrier."""
    if forks:
        fault = "is an archipelago, which cannot be forked as a whole"
        allowed = "one of its islands, which then continues alone: DIR/islands/NAME"
        refuse("DIR", fault, str(folder), allowed)
    _go(Archipelago(folder), folder.name, how, until=until)


def _go(made: Archipelago, name: str, how: How, **more: Any) -> None:
    try:
        with progress(name, how.quiet, "ticks of islands") as bar:
            manifest = made.run(workers=how.workers, on=how.on, progress=bar, **how.common, **more)
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
