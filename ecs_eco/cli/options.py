"""Arguments and options that several commands have, with their words."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.terminal import path_of, whole

World = Annotated[str, typer.Argument(metavar="WORLD", help="Name of a shipped world (see `list`), or a TOML file.")]
Ticks = Annotated[
    int | None, typer.Option(parser=whole(1), metavar="N", help="Length [ticks]; the world's own where absent.")
]
Seed = Annotated[
    int | None, typer.Option(parser=whole(0, 2**63 - 1), metavar="N", help="Seed of all chance; else the world's own.")
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the world: species.deer.count=500. Repeatable."),
]
Out = Annotated[Path | None, typer.Option(parser=path_of, metavar="PATH", help="Folder for the results: new or empty. Default: in runs/.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")]
Threads = Annotated[
    int, typer.Option(parser=whole(1, 1024), metavar="N", help="Threads; they change the speed and no result.")
]
Learn = Annotated[
    bool | None, typer.Option("--learn/--no-learn", help="Whether policies learn; else as the world says.")
]
Policies = Annotated[
    str, typer.Option(metavar="trained|random|DIR", help="What policies start from: a folder that `train` left.")
]
Watch = Annotated[
    bool, typer.Option("--watch", help="Show it in the browser meanwhile; what is done there is recorded.")
]
Port = Annotated[
    int, typer.Option(parser=whole(0, 65535), metavar="N", help="Port of the viewer on this machine; 0: any free one.")
]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Only say the viewer's address.")]
Trust = Annotated[
    bool, typer.Option("--trust", help="Allow the code of its own that it names to run here, until that changes; read it first.")
]
Report = Annotated[bool, typer.Option("--report/--no-report", help="Draw figures at the end.")]
Run = Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `run` left.")]
Size = Annotated[str, typer.Option(metavar="WIDTHxHEIGHT", help="In pixels.")]
