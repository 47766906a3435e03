"""The command export: a recorded run as a page in one file."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.options import Quiet, Run, Trust, number
from ecs_eco.cli.terminal import exits, progress, recorded, refuse, say
from ecs_eco.cli.trust import allow
from ecs_eco.engine import files
from ecs_eco.record.archipelago import ISLANDS, is_archipelago
from ecs_eco.view.export import page
from ecs_eco.view.replay import Replay


@exits
def export(
    folder: Run,
    html: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="A new .html file. Default: WORLD.html in the current folder."),
    ] = None,
    size: Annotated[
        int, number("Maximum size in MB; of a larger run, only some organisms are included.", most=1000)
    ] = 10,
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Save a recorded run as one HTML file that opens without a server or a network."""
    if is_archipelago(folder):
        refuse(
            "DIR", "is an archipelago", str(folder), f"one of its islands, such as {folder / ISLANDS}/NAME"
        )
    recorded(folder)
    allow(trust, folder)
    replay = Replay(folder)
    path = html or Path(f"{replay.recording.manifest['world']}.html")
    if path.suffix.lower() not in (".html", ".htm"):
        refuse("--html", "unsupported format", str(path), "a file ending in .html", f"{path.stem}.html")
    if path.exists():
        refuse("--html", "already exists", str(path), "a new file")
    with progress(path.name, quiet, "steps") as show:
        text = page(replay, size * 1_000_000, show)
    with files.writing(path) as beside:
        beside.write_text(text, encoding="utf-8")
    say(f"{path}: {len(text) / 1e6:.1f} MB; open it in a browser")
