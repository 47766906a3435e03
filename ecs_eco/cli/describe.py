"""The command describe."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.analysis.page import write_text
from ecs_eco.cli.options import Set, Trust, World
from ecs_eco.cli.terminal import complain, exits, path_of, refuse, say
from ecs_eco.cli.trust import allow
from ecs_eco.config import load
from ecs_eco.odd import describe as description


@exits
def describe(
    world: World,
    html: Annotated[bool, typer.Option("--html", help="Write an HTML page instead of Markdown.")] = False,
    out: Annotated[
        Path | None,
        typer.Option(parser=path_of, metavar="FILE", help="Write to this file instead of the terminal."),
    ] = None,
    set_: Set = None,
    trust: Trust = False,
) -> None:
    """Describe a world in the ODD protocol, as Markdown or HTML."""
    allow(trust, world, set_)
    document = description(load(world, set_ or []))
    text = document.html() if html else document.markdown()
    if out is None:
        return say(text.rstrip())
    try:
        write_text(out, text)
    except OSError as error:
        refuse("--out", f"cannot be written: {error.strerror}", str(out), "a file in a writable folder")
    complain(f"Wrote {out}.")
