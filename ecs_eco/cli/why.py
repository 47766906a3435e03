"""why: what happened in a run, and why."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from ecs_eco.cli.archipelago import refuse_islands
from ecs_eco.cli.folders import pages
from ecs_eco.cli.terminal import printable, refuse, say


def tell_why(folder: Path, out: Path | None, as_json: bool) -> None:
    """Explain a run folder in sentences or as JSON; write the page and the figure."""
    refuse_islands(folder)
    if not (folder / "manifest.json").is_file():
        fault = "has no manifest.json" if folder.is_dir() else "no such folder"
        refuse("DIR", fault, str(folder), "a folder written by `ecs-eco run`")
    from ecs_eco.analysis.runs import parts
    from ecs_eco.analysis.why import write_why

    if not parts(folder, "series"):
        refuse("DIR", "holds no series", str(folder), "a run of one tick or more")
    pages(out, folder)
    findings = write_why(folder, out)
    if as_json:
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
