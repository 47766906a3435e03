"""The command explain: which alleles rose in a run, and what taking them out of forks changes."""

import json
from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.folders import pages
from ecs_eco.cli.options import Of, Quiet, Run, Trust, Workers, new_folder, number, option
from ecs_eco.cli.terminal import exits, progress, recorded, refuse, say
from ecs_eco.engine.errors import CheckpointError, ConfigError, RecordingError
from ecs_eco.explain.account import MOMENTS
from ecs_eco.explain.page import write_explanation
from ecs_eco.lab.executors import LOCAL, check_engine
from ecs_eco.record.archipelago import is_archipelago


@exits
def explain(
    folder: Run,
    out: Annotated[
        Path | None, new_folder("Folder for explain.html, explain.json and the figures. Default: DIR.")
    ] = None,
    species: Of = None,
    forks: Annotated[
        int, number("Forks for each allele; 0: only find what rose.", least=0, most=10_000)
    ] = 24,
    tick: Annotated[
        list[str] | None,
        typer.Option(
            metavar="N|before|within|after",
            help="Tick of the forks, or: when the rise begins (before), is half over (within) or ends (after). "
            "Repeatable. Default: within.",
        ),
    ] = None,
    ticks: Annotated[int | None, number("Maximum length of a fork. Default: the length of the run.")] = None,
    fdr: Annotated[
        float, typer.Option(metavar="X", help="False discovery rate of the alleles that rose.")
    ] = 0.01,
    seed: Annotated[int, number("Seed of the forks.", least=0, most=2**63 - 1)] = 0,
    learned: Annotated[
        bool,
        typer.Option("--learned", help="Also undo learning: is an advantage inherited, learned or both?"),
    ] = False,
    reverse: Annotated[
        bool,
        typer.Option("--reverse", help="Also put each sweep's leading allele into organisms without it."),
    ] = False,
    together: Annotated[
        bool,
        typer.Option(
            "--together", help="Also take out the alleles of a species' two clearest sweeps together."
        ),
    ] = False,
    workers: Workers = None,
    on: Annotated[
        str,
        option(
            "Where to run forks: in processes on this machine, on a Ray cluster, or on a SLURM cluster.",
            "--on",
            metavar="local|ray|slurm",
        ),
    ] = LOCAL,
    json_: Annotated[bool, typer.Option("--json", help="Print explain.json instead of sentences.")] = False,
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Explain which alleles rose in a run, and what taking them out changes."""
    if not is_archipelago(folder):
        recorded(folder)
    if not 0 < fdr < 1:
        refuse("--fdr", "is not a proportion", fdr, "a number between 0 and 1, such as 0.01")
    ticks_of_forks = [int(word) if word.isdecimal() else word for word in tick or ()]
    for at in ticks_of_forks:
        if isinstance(at, str) and at not in MOMENTS:
            refuse("--tick", "is not a tick", at, "a whole number, before, within or after")
    check_engine(on)
    pages(out, folder)
    with progress("forks", quiet, "forks") as show:
        try:
            found = write_explanation(
                folder,
                out,
                species=species,
                fdr=fdr,
                forks=forks,
                learned=learned,
                reverse=reverse,
                together=together,
                progress=show,
                tick=ticks_of_forks,
                ticks=ticks,
                seed=seed,
                engine=on,
                workers=workers,
                trust=trust,
            )
        except (ConfigError, RecordingError, CheckpointError):
            raise
        except (KeyError, ValueError) as error:
            refuse("DIR", str(error.args[0]), str(folder), "")
    if json_:
        return say(json.dumps(found, indent=1, ensure_ascii=False))
    for lines in (found["summary"], *(sweep["sentences"] for sweep in found["sweeps"])):
        say(" ".join(lines) + "\n")
    say(f"written: {(out or folder) / 'explain.html'}")
