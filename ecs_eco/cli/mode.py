"""In which mode a sweep computes: that of its folder; new on several machines the portable one.

Nothing is imported here that loads numpy, which must come after the choice.
"""

import json
import os
from pathlib import Path

from ecs_eco.cli.terminal import REFUSED, complain
from ecs_eco.engine import portable

SEVERAL = ("ray", "slurm")  # engines whose machines may have different processors


def settle(on: str | None, folder: Path | None) -> None:
    """Enable the portable mode where the sweep in a folder was begun in it, or where a new one is to run on
    several machines, they are x86-64, and ECS_ECO_PORTABLE does not say 0; end the command where it cannot
    be had."""
    import typer

    noted = mode_of(folder)
    new = noted is None and on in SEVERAL and portable.VARIABLE not in os.environ and portable.possible()
    try:
        if noted == "portable" or new:
            portable.enable()
    except portable.PortableError as error:
        complain(str(error))
        raise typer.Exit(REFUSED) from None


def mode_of(folder: Path | None) -> str | None:
    """Return the mode that a sweep's folder notes; None where there is no sweep, or none that can be read."""
    try:
        content = json.loads((folder / "sweep.json").read_text(encoding="utf-8")) if folder else {}
        return str(content["mode"])
    except (OSError, ValueError, TypeError, KeyError):
        return None
