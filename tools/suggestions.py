"""Print the suggestion for each broken input in tests/config/broken_inputs.toml, in one or two versions of
the program.

PYTHONPATH=TREE python tools/suggestions.py > now.json        the answers of one version
python tools/suggestions.py before.json now.json              a table of two versions
"""

from __future__ import annotations

import json
import os
import re
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from ecs_eco.cli import app

ROOT = Path(__file__).parents[1]
INPUTS = ROOT / "tests/config/broken_inputs.toml"
WORLDS = ROOT / "tests/wrong_worlds.py"


def inputs() -> list[dict[str, Any]]:
    """Return the broken inputs."""
    return tomllib.loads(INPUTS.read_text())["input"]


def world() -> str:
    """Return the world that the inputs break."""
    match = re.search(r'^WORLD = """\\\n(.*?)^"""', WORLDS.read_text(), re.DOTALL | re.MULTILINE)
    assert match is not None
    return match[1]


def answer(case: dict[str, Any]) -> dict[str, Any]:
    """Return the exit code, number of problems, suggestion and message for a broken input, run in an empty
    folder."""
    arguments = case.get("args") or ["check", "predator-prey", "--set", case.get("set", "")]
    if "old" in case:
        text = world()
        assert text.count(case["old"]) == 1, case["old"]
        Path("world.toml").write_text(text.replace(case["old"], case["new"]))
        arguments = ["check", "world.toml"]
    done = CliRunner().invoke(app, arguments)
    message = done.stderr.strip()
    found = re.search(r"did you mean \"(.*?)\"\?", message)
    count = re.search(r"(\d+) problems?$", message, re.MULTILINE)
    return {
        "input": label(case),
        "suggestion": found[1] if found else "",
        "problems": int(count[1]) if count else 1,
        "code": done.exit_code,
        "message": message,
    }


def label(case: dict[str, Any]) -> str:
    """Return a broken input as one line."""
    if "args" in case:
        return "ecs-eco " + " ".join(case["args"])
    return f"--set {case['set']}" if "set" in case else case["new"].strip().replace("\n", "; ")


def table(before: list[dict[str, Any]], now: list[dict[str, Any]]) -> str:
    """Return two versions' suggestions as Markdown."""
    rows = ["| input | before | now |", "|---|---|---|"]
    rows += [f"| `{a['input']}` | {_cell(a)} | {_cell(b)} |" for a, b in zip(before, now, strict=True)]
    return "\n".join(rows)


def _cell(row: dict[str, Any]) -> str:
    parts = [f"`{row['suggestion']}`"] if row["suggestion"] else []
    parts += re.findall(r'belongs to (kind = "\w+")', row["message"])
    parts += [f"{row['problems']} problems"] if row["problems"] > 1 else []
    parts += [f"exit code {row['code']}"] if row["code"] != 2 else []
    return ", ".join(parts) or "–"


def main() -> None:
    """Print the answers or a table."""
    if len(sys.argv) == 3:
        print(table(*(json.loads(Path(name).read_text()) for name in sys.argv[1:])))
        return
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        print(json.dumps([answer(case) for case in inputs()], indent=1))


if __name__ == "__main__":
    main()
