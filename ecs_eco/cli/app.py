"""`ecs-eco run | watch | resume | …`: the table of commands, and what all of them take."""

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from ecs_eco.cli.terminal import REFUSED, complain, say
from ecs_eco.compiled.garbage import of_a_command
from ecs_eco.compiled.portable import PortableError, check, enable

COMMANDS = {  # the module of each command, and its help, as its docstring or its group has it
    "run": ("run", "Run a world and record it in a folder; `resume` continues it."),
    "watch": ("watch", "Watch a living world or a recorded run in the browser, or two side by side."),
    "repeat": ("run", "Repeat a recorded run, with all interventions, and print whether it ends the same."),
    "resume": ("run", "Resume a run from its last checkpoint, or fork it with changed values."),
    "train": ("train", "Train a world's policies and save them."),
    "report": ("telling", "Draw the figures of a run."),
    "why": ("telling", "Explain what happened in a run, why, and which values to change."),
    "lineage": ("telling", "Print and write the lineages of a run."),
    "tracks": ("telling", "Write where organisms were, as geographic data."),
    "compare": (
        "compare",
        "Compare a world with itself under treatments; the same command with --out DIR resumes a stopped\n"
        "comparison.",
    ),
    "search": ("search", "Search for values with which a world persists."),
    "draw": ("picture", "Draw the nervous systems of a world's species."),
    "picture": ("picture", "Draw a tick of a recorded run."),
    "video": ("picture", "Make a film of a recorded run."),
    "new": ("beginning", "Write a world of your own to begin with: a file, a system and its test."),
    "list": ("docs", "List worlds, sensors, components and systems."),
    "check": ("summary", "Check a world file and print a summary."),
    "describe": ("describe", "Describe a world by the ODD protocol, as Markdown or HTML."),
    "doctor": (
        "doctor",
        "Print what results depend on here, and whether they agree with the release: exit code 1 if not.",
    ),
    "docs": ("docs", "Open the documentation, from the copy on this machine."),
    "sweep": (
        "sweeping",
        "Run a world under many values, seeds and treatments: sweep PLAN [--on local|slurm|ray] "
        "[--workers N] [--sbatch OPTION] [--out DIR] [--quiet] [--trust]; then status, resume and collect.",
    ),
    "cache": ("cache", "Compiled kernels, which are kept between runs: show, warm and clear."),
    "world": ("beginning", "Write a world file: world from-raster RASTER [FILE]."),
}


app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # rich is loaded by the commands that draw with it
    help="Ecosystems whose animals sense, learn and evolve.",
)


def loaded(name: str) -> Any:
    """Import the module of a command; return the click command or group."""
    work = getattr(import_module(f"ecs_eco.cli.{COMMANDS[name][0]}"), "list_" if name == "list" else name)
    if not isinstance(work, typer.Typer):
        work, command = typer.Typer(add_completion=False, rich_markup_mode=None), work
        work.command(name)(command)
    return typer.main.get_command(work)


class Command(TyperCommand):
    """A command that `--help` lists, whose module is imported when it is called, in the mode chosen by then."""

    def make_context(self, info_name: str | None, args: list[str], *more: Any, **extra: Any) -> Any:
        """Parse the arguments of the command itself."""
        return loaded(str(self.name)).make_context(info_name, args, *more, **extra)


for _name, (_, _help) in COMMANDS.items():
    app.command(_name, cls=Command, help=_help)(lambda: None)


def _version(wanted: bool) -> None:
    if wanted:
        try:
            say(f"ecs-eco {version('ecs-eco')}")
        except PackageNotFoundError:
            say("ecs-eco, not installed: the version is unknown")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_version, help="Print the version and exit.")
    ] = False,
    portable: Annotated[
        bool,
        typer.Option(
            "--portable",
            help="Give the same bytes on every x86-64 machine, more slowly; as ECS_ECO_PORTABLE=1 does.",
        ),
    ] = False,
) -> None:
    try:
        enable() if portable else check()
    except PortableError as error:
        complain(str(error))
        raise typer.Exit(REFUSED) from None


def main() -> None:
    """Entry point of the command `ecs-eco`."""
    with of_a_command():
        app(prog_name="ecs-eco")
