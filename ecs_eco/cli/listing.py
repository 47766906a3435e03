"""Lists what is available, read from the text of files, so that nothing is imported."""

from __future__ import annotations

import ast
from pathlib import Path

from ecs_eco.cli.terminal import say

ROOT = Path(__file__).parent.parent


def list_() -> None:
    """List worlds, sensors, components and systems."""
    from ecs_eco.config.shipped import titles

    sections = {
        "Worlds": titles(),
        "Sensors": dict(_classes(ROOT / "config" / "models" / "sensors.py", "kind")),
        "Components": dict(_folder("components")),
        "Systems": dict(_folder("systems", "System")),
    }
    say("\n\n".join(_table(title, rows) for title, rows in sections.items()))


def _folder(name: str, base: str = "") -> list[tuple[str, str]]:
    """Public classes of a folder and the first lines of their docstrings."""
    return [row for path in sorted((ROOT / name).glob("[!_]*.py")) for row in _classes(path, base=base)]


def _classes(path: Path, label: str = "", base: str = "") -> list[tuple[str, str]]:
    """(name, first line) of the public classes of a file, or of those of a base;
    named by their one choice of `label` if given."""
    rows = []
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        of_base = not base or (isinstance(node, ast.ClassDef) and base in map(ast.unparse, node.bases))
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_") and of_base:
            name = _choice(node, label) if label else node.name
            if name:
                rows.append((name, " ".join((ast.get_docstring(node) or "").partition("\n\n")[0].split())))
    return rows


def _choice(node: ast.ClassDef, label: str) -> str:
    for line in node.body:
        if isinstance(line, ast.AnnAssign) and ast.unparse(line.target) == label:
            return next(  # type: ignore[return-value]
                (c.value for c in ast.walk(line.annotation) if isinstance(c, ast.Constant)), ""
            )
    return ""


def _table(title: str, rows: dict[str, str]) -> str:
    width = max(map(len, rows), default=0)
    return "\n".join([title, *(f"  {name:<{width}}  {text}".rstrip() for name, text in rows.items())])
