"""A figure of a result, drawn from its JSON: the command that all of them share."""

import argparse
import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]


def draw_result(says: str, name: str, figure: str, draw: Callable[[dict[str, Any], Path], Any]) -> None:
    """Read studies/results/NAME.json, or the file that the command line names, and let `draw` write its
    figure to docs/img; `says` is the text of the module that is run."""
    parser = argparse.ArgumentParser(description=says.partition("\n\n")[0])
    parser.add_argument("--results", type=Path, default=ROOT / "studies" / "results" / f"{name}.json")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "img" / figure)
    parser.add_argument("--short", action="store_true", help="for CI: draw into a temporary folder")
    asked = parser.parse_args()
    if asked.short:
        asked.out = Path(tempfile.mkdtemp(prefix="ecs-eco-figure-")) / asked.out.name
        if not asked.results.is_file():
            print(f"{asked.results}: the study was not run yet")
            return
    draw(json.loads(asked.results.read_text(encoding="utf-8")), asked.out)
    print(asked.out)
