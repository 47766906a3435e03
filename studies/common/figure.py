"""The command line of scripts that draw a figure from a result's JSON file, and the stored series of a run."""

import argparse
import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.seed_grid import BLOCK

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


def series(result: dict[str, Any], name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return times [1,000 ticks] and numbers of a species from a cell's result."""
    n = np.array([float(v) for v in result["series"][name].split()])
    return BLOCK * (np.arange(len(n)) + 0.5) / 1000, n
