"""`ecs-eco run | watch | resume | …`: the table of commands, and the options of all commands."""

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from ecs_eco.cli.terminal import REFUSED, complain, say
from ecs_eco.compiled.garbage import of_a_command
from ecs_eco.compiled.portable import PortableError, check, enable

COMMANDS = {  # each command's module and its help, which is the same as its docstring or its group's help
    "run": ("run", "Run a world and record it in a folder; `resume` continues it."),
    "watch": ("watch", "Watch a live world or a recorded run in the browser, or two of them side by side."),
    "repeat": (
        "run",
        "Repeat a recorded run with all its interventions, and check that the result is the same.",
    ),
    "resume": ("run", "Resume a run from its last checkpoint, or fork it with changed values."),
    "train": ("train", "Train a world's policies and save them."),
    "report": ("telling", "Draw a run's figures and write its report."),
    "why": ("telling", "Explain what happened in a run and why, and suggest values to change."),
    "explain": ("explaining", "Explain which alleles rose in a run, and what taking them out changes."),
    "lineage": ("telling", "Summarize the lineages of a run, and write them to files."),
    "tracks": ("telling", "Export the positions of organisms as geographic data."),
    "compare": (
        "compare",
        "Compare a world with and without treatments; the same command with --out DIR resumes a stopped\n"
        "comparison.",
    ),
    "search": ("search", "Search for values that let a world persist."),
    "draw": ("picture", "Draw the nervous systems of a world's species."),
    "picture": ("picture", "Draw a tick of a recorded run."),
    "video": ("picture", "Make a video of a recorded run."),
    "export": ("exporting", "Save a recorded run as one HTML file that opens without a server or a network."),
    "new": ("beginning", "Write a starter world: a world file, a system and its test."),
    "list": ("docs", "List worlds, sensors, components and systems."),
    "check": ("summary", "Check a world file and print a summary."),
    "describe": ("describe", "Describe a world in the ODD protocol, as Markdown or HTML."),
    "doctor": (
        "doctor",
        "Print the settings that affect results, and compare results with the release; exit code 1 if any differ.",
    ),
    "docs": ("docs", "Open the installed documentation."),
    "sweep": (
        "sweeping",
        "Run a world under many values, seeds and treatments: sweep PLAN [--on local|slurm|ray] "
        "[--workers N] [--design NAME] [--until-width W --response NAME --most N] [--sbatch OPTION] "
        "[--out DIR] [--quiet] [--trust]; then status, resume and collect.",
    ),
    "cache": ("cache", "Manage the cache of compiled kernels: show, warm and clear."),
    "world": ("beginning", "Write a world file: world from-raster RASTER [FILE]."),
}


app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # only commands that print with rich import it
    help="Simulate ecosystems whose animals sense, learn and evolve.",
)


def loaded(name: str) -> Any:
    """Import a command's module, and return its click command or group."""
    work = getattr(import_module(f"ecs_eco.cli.{COMMANDS[name][0]}"), "list_" if name == "list" else name)
    if not isinstance(work, typer.Typer):
        work, command = typer.Typer(add_completion=False, rich_markup_mode=None), work
        work.command(name)(command)
    return typer.main.get_command(work)


class Command(TyperCommand):
    """A command listed by `--help`; calling it imports its module in the chosen numerical mode."""

    def make_context(self, info_name: str | None, args: list[str], *more: Any, **extra: Any) -> Any:
        """Parse the command's own arguments."""
        return loaded(str(self.name)).make_context(info_name, args, *more, **extra)


for _name, (_, _help) in COMMANDS.items():
    app.command(_name, cls=Command, help=_help)(lambda: None)


def _version(wanted: bool) -> None:
    if wanted:
        try:
            say(f"ecs-eco {version('ecs-eco')}")
        except PackageNotFoundError:
            say("ecs-eco is not installed; its version is unknown")
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
            help="Compute the same bytes on every x86-64 machine, but more slowly; like ECS_ECO_PORTABLE=1.",
        ),
    ] = False,
) -> None:
    try:
        enable() if portable else check()
    except PortableError as error:
        complain(str(error))
        raise typer.Exit(REFUSED) from None


def main() -> None:
    """Run the `ecs-eco` command."""
    with of_a_command():
        app(prog_name="ecs-eco")
