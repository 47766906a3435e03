"""The command-line entry point for scripts that draw a figure from a result's JSON file."""

import argparse
import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]


def draw_result(says: str, name: str, figure: str, draw: Callable[[dict[str, Any], Path], Any]) -> None:
    """Read studies/results/NAME.json, or the file named on the command line, and call `draw` to write its
    figure to docs/img. `says` is the docstring of the calling module."""
    parser = argparse.ArgumentParser(description=says.partition("\n\n")[0])
    parser.add_argument("--results", type=Path, default=ROOT / "studies" / "results" / f"{name}.json")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "img" / figure)
    parser.add_argument("--short", action="store_true", help="for CI: write to a temporary folder")
    asked = parser.parse_args()
    if asked.short:
        asked.out = Path(tempfile.mkdtemp(prefix="ecs-eco-figure-")) / asked.out.name
        if not asked.results.is_file():
            print(f"{asked.results}: no result; run the study first")
            return
    draw(json.loads(asked.results.read_text(encoding="utf-8")), asked.out)
    print(asked.out)
