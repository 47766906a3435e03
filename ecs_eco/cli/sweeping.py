"""The commands sweep PLAN and sweep status | resume | collect, and the numerical mode of a sweep.

This module must not import anything that loads numpy, because the mode must be chosen first.
"""

import os
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from ecs_eco.cli.options import Quiet, new_folder, number
from ecs_eco.cli.terminal import REFUSED, complain, exits
from ecs_eco.compiled import portable
from ecs_eco.engine.files import read_note

SEVERAL = ("ray", "slurm")  # engines whose jobs may run on different processors


class PlanOrCommand(TyperGroup):
    """A command group that passes a plan's name to its command `run`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Insert `run` before anything except a command or a request for help."""
        if args and args[0] not in self.commands and args[0] not in ("--help", "-h"):
            args = ["run", *args]
        return super().parse_args(ctx, args)


sweep = typer.Typer(
    cls=PlanOrCommand,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    help="Run a world under many values, seeds and treatments: sweep PLAN [--on local|slurm|ray] "
    "[--workers N] [--design NAME] [--until-width W --response NAME --most N] [--sbatch OPTION] "
    "[--out DIR] [--quiet] [--trust]; then status, resume and collect.",
)

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a sweep.")]
On = Annotated[
    str,
    typer.Option(
        "--on",
        metavar="local|slurm|ray",
        help="Where to run: in processes on this machine, on a SLURM cluster, or on a Ray cluster.",
    ),
]
Workers = Annotated[
    int | None,
    number(
        "Number of concurrent jobs, with one thread each. Default: 2; on Ray, all CPUs; on SLURM, 100.",
        most=100_000,
    ),
]
Sbatch = Annotated[
    list[str] | None,
    typer.Option(
        metavar="OPTION", help="Option passed to SLURM's sbatch, such as --time=2:00:00. Repeatable."
    ),
]
Trust = Annotated[
    bool,
    typer.Option(
        "--trust", help="Allow the world's own Python code to run until it changes. Read the code first."
    ),
]


@sweep.command()
@exits
def run(
    plan: Annotated[str, typer.Argument(metavar="PLAN", help="The plan: a TOML file.")],
    on: On = "local",
    workers: Workers = None,
    sbatch: Sbatch = None,
    out: Annotated[
        Path | None, new_folder("Results folder: new, empty, or begun with this plan. Default: in runs/.")
    ] = None,
    quiet: Quiet = False,
    trust: Trust = False,
    design: Annotated[
        str | None,
        typer.Option(
            metavar="lhs|sobol|morris",
            help="How to draw the points of [sample]. sobol and morris compute sensitivity indices.",
        ),
    ] = None,
    until_width: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            metavar="WIDTH",
            help="Run only as many world seeds as needed for a 95% interval of the mean response that is at most "
            "this wide at each point.",
        ),
    ] = None,
    response: Annotated[
        str,
        typer.Option(metavar="COLUMN", help="Column of runs.parquet for --until-width, such as wolf.mean."),
    ] = "persisted",
    most: Annotated[
        int | None, number("Number of world seeds, instead of the plan's; a maximum with --until-width.")
    ] = None,
) -> None:
    """Run all jobs of a plan; `sweep PLAN` is short for `sweep run PLAN`."""
    until = None if until_width is None else (response, until_width)
    _work(on, out).sweep_plan(plan, on, workers, out, quiet, trust, sbatch or [], design, most, until)


@sweep.command()
@exits
def status(folder: Folder) -> None:
    """Show finished, running, queued and failed jobs, speed and time left."""
    _work().tell_status(folder)


@sweep.command()
@exits
def resume(
    folder: Folder,
    on: On = "local",
    workers: Workers = None,
    sbatch: Sbatch = None,
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Resume the unfinished jobs, including failed ones."""
    _work(None, folder).resume_sweep(folder, on, workers, quiet, trust, sbatch or [])


@sweep.command()
@exits
def collect(folder: Folder, quiet: Quiet = False) -> None:
    """Write one table of all finished runs, with figures and a report."""
    _work().collect_sweep(folder, quiet)


@sweep.command(hidden=True)
@exits
def job(
    folder: Folder, numbers: Annotated[list[int], typer.Argument(metavar="NUMBER…")], trust: Trust = False
) -> None:
    """Run the jobs with these numbers in this process; exit with code 75 if stopped by a signal."""
    _work(None, folder).do_jobs_here(folder, numbers, trust)


def _work(on: str | None = None, folder: Path | None = None) -> ModuleType:
    """Set the numerical mode, then import and return the module that does the work, which loads numpy."""
    settle(on, folder)
    from ecs_eco.cli import sweep

    return sweep


def settle(on: str | None, folder: Path | None) -> None:
    """Enable portable mode if the folder's sweep was begun in it, or if a new sweep may run on several x86-64
    machines and ECS_ECO_PORTABLE is not set. End the command if the mode is unavailable."""
    noted = mode_of(folder)
    new = noted is None and on in SEVERAL and portable.VARIABLE not in os.environ and portable.possible()
    try:
        if noted == "portable" or new:
            portable.enable()
    except portable.PortableError as error:
        complain(str(error))
        raise typer.Exit(REFUSED) from None


def mode_of(folder: Path | None) -> str | None:
    """Return the numerical mode recorded in a sweep's folder, or None if there is no readable sweep."""
    content = read_note(folder / "sweep.json") if folder else {}
    return str(content["mode"]) if "mode" in content else None
