"""The command why: what happened in a run, and why."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from ecs_eco.cli.terminal import exits, path_of, printable, recorded, refuse, say


@exits
def why(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="A folder written by `run`, finished or not.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            parser=path_of, metavar="PATH", help="Folder for why.html, why.json and the figure. Default: DIR."
        ),
    ] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print why.json instead of sentences.")] = False,
) -> None:
    """Explain what happened in a run, why, and which values to change."""
    from ecs_eco.cli.archipelago import refuse_islands

    refuse_islands(folder)
    recorded(folder)
    from ecs_eco.analysis.runs import parts
    from ecs_eco.analysis.why import write_why
    from ecs_eco.cli.folders import pages

    if not parts(folder, "series"):
        refuse("DIR", "holds no series", str(folder), "a run of one tick or more")
    pages(out, folder)
    findings = write_why(folder, out)
    if json_:
        say(json.dumps({k: v for k, v in findings.items() if k != "sentences"}, indent=1, ensure_ascii=False))
        return
    _print(findings["sentences"])
    say(f"\nwritten: {(out or folder) / 'why.html'}")


def _print(blocks: dict[str, list[str]]) -> None:
    """Sentences under their headings, as wide as the terminal."""
    from rich.console import Console
    from rich.padding import Padding
    from rich.text import Text

    console: Any = Console(file=sys.stdout, highlight=False, width=None if sys.stdout.isatty() else 110)
    for head, lines in blocks.items():
        console.print(Text(printable(f"\n{head}" if head != next(iter(blocks)) else head), style="bold"))
        for line in lines:
            console.print(Padding(Text(printable(line)), (0, 0, 0, 2)))
