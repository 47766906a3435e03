"""Arguments and options of several commands, with their help texts."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.terminal import path_of, whole

World = Annotated[
    str, typer.Argument(metavar="WORLD", help="Name of a shipped world (see `list`), or a TOML file.")
]
Ticks = Annotated[
    int | None,
    typer.Option(parser=whole(1), metavar="N", help="Length [ticks]. Default: as in the world file."),
]
Seed = Annotated[
    int | None,
    typer.Option(
        parser=whole(0, 2**63 - 1),
        metavar="N",
        help="Seed of all random numbers. Default: as in the world file.",
    ),
]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Change a value of the world: species.deer.count=500. Repeatable."
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(
        parser=path_of, metavar="PATH", help="Folder for the results: new or empty. Default: in runs/."
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")]
Threads = Annotated[
    int,
    typer.Option(
        parser=whole(1, 1024), metavar="N", help="Number of threads. It affects speed, never results."
    ),
]
Learn = Annotated[
    bool | None,
    typer.Option("--learn/--no-learn", help="Whether policies learn. Default: as in the world file."),
]
Policies = Annotated[
    str,
    typer.Option(
        metavar="trained|random|DIR",
        help="Initial policies: trained, random, untrained, or a folder written by `train`.",
    ),
]
Watch = Annotated[
    bool, typer.Option("--watch", help="Show the run in the browser; interventions made there are recorded.")
]
Port = Annotated[
    int,
    typer.Option(
        parser=whole(0, 65535), metavar="N", help="Port of the viewer on this machine; 0: any free port."
    ),
]
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
        help="Share the work among the processes of `mpiexec -n N ecs-eco … --bands`; the result is the same.",
    ),
]
Divided = Annotated[
    bool,
    typer.Option(
        "--divided",
        help="The same as --bands, but each process holds only its part of the world, so memory is divided too.",
    ),
]
On = Annotated[
    str,
    typer.Option(
        "--on", metavar="local|ray", help="Where to run: processes on this machine, or a Ray cluster."
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(
        parser=whole(1, 1024),
        metavar="N",
        help="Number of processes, with one thread each. Default: 2; on Ray all CPUs.",
    ),
]
Report = Annotated[bool, typer.Option("--report/--no-report", help="Draw figures at the end.")]
Of = Annotated[str | None, typer.Option(metavar="NAME", help="Only this species.")]
Run = Annotated[Path, typer.Argument(metavar="DIR", help="A folder written by `run`.")]
Size = Annotated[str, typer.Option(metavar="WIDTHxHEIGHT", help="In pixels.")]
