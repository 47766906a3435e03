"""Arguments and options that several commands share, with their help texts."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from ecs_eco.cli.terminal import path_of, whole


def number(help: str, *names: str, least: int = 1, most: int = 10**12, metavar: str = "N") -> Any:
    """Return an option that takes an integer from `least` to `most`."""
    return typer.Option(*names, parser=whole(least, most), metavar=metavar, help=help)


def option(help: str, *names: str, metavar: str = "NAME") -> Any:
    """Return an option that takes a text."""
    return typer.Option(*names, metavar=metavar, help=help)


def new_folder(help: str) -> Any:
    """Return an option that takes the path of a folder."""
    return typer.Option(parser=path_of, metavar="PATH", help=help)


def words(**options: object) -> list[str]:
    """Return options as words of a command: True as a flag, a list as a repeated option, and None or False not at
    all."""
    found: list[str] = []
    for name, value in options.items():
        for one in value if isinstance(value, list) else [value]:
            if one is not None and one is not False:
                found += [f"--{name.replace('_', '-')}", *([] if one is True else [str(one)])]
    return found


World = Annotated[
    str, typer.Argument(metavar="WORLD", help="Name of a shipped world (see `list`) or a TOML file.")
]
Ticks = Annotated[int | None, number("Number of ticks. Default: as in the world file.")]
Seed = Annotated[
    int | None, number("Seed of all random draws. Default: as in the world file.", least=0, most=2**63 - 1)
]
Set = Annotated[
    list[str] | None,
    option(
        "Change a value of the world, such as species.deer.count=500. Repeatable.",
        "--set",
        metavar="KEY=VALUE",
    ),
]
Out = Annotated[Path | None, new_folder("Results folder: new or empty. Default: a new folder in runs/.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")]
Threads = Annotated[int, number("Number of threads; affects speed, never results.", most=1024)]
Learn = Annotated[
    bool | None,
    typer.Option("--learn/--no-learn", help="Whether policies learn. Default: as in the world file."),
]
Policies = Annotated[
    str,
    option(
        "Initial policies: trained, random, untrained, or a folder written by `train`.",
        metavar="trained|random|untrained|DIR",
    ),
]
Watch = Annotated[
    bool,
    typer.Option(
        "--watch", help="Show the run in the browser, where you can intervene; interventions are recorded."
    ),
]
Port = Annotated[int, number("Port of the viewer on this machine (0: any free port).", least=0, most=65535)]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Only print the viewer's address.")]
Trust = Annotated[
    bool,
    typer.Option(
        "--trust",
        help="Allow this world's own Python code to run here until it changes. Read the code first.",
    ),
]
Bands = Annotated[
    bool,
    typer.Option(
        "--bands",
        help="Divide the work among the processes of `mpiexec -n N ecs-eco … --bands`; the result is the same.",
    ),
]
Divided = Annotated[
    bool,
    typer.Option(
        "--divided",
        help="Like --bands, but each process stores only its part of the world, so memory is divided, too.",
    ),
]
On = Annotated[
    str,
    option("Where to run: in processes on this machine, or on a Ray cluster.", "--on", metavar="local|ray"),
]
Workers = Annotated[
    int | None, number("Number of processes, with one thread each. Default: 2; on Ray, all CPUs.", most=1024)
]
Report = Annotated[bool, typer.Option("--report/--no-report", help="Draw figures at the end.")]
Of = Annotated[str | None, option("Only this species.")]
Run = Annotated[Path, typer.Argument(metavar="DIR", help="A folder written by `run`.")]
Size = Annotated[str, option("Size of the picture, in pixels.", metavar="WIDTHxHEIGHT")]


@dataclass(frozen=True)
class How:
    """Options of a run that do not affect its results."""

    quiet: bool
    threads: int
    report: bool
    shown: tuple[int, bool] | None  # the viewer's port, and whether to open the browser
    workers: int | None
    on: str
