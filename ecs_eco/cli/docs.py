"""The commands docs and list: open the documentation, and list features from their source code."""

import ast
import os
import sys
import webbrowser
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated

import typer

import ecs_eco
from ecs_eco.cli.terminal import complain, exits, refuse, say
from ecs_eco.config.shipped import titles

PACKAGE = Path(ecs_eco.__file__).parent
SITE = PACKAGE / "_site"  # tools/build_site.py writes it, and the wheel includes it
SOURCES = PACKAGE.parent / "docs"  # in a copy of the source code
BUILD = "pip install -e '.[docs]' && python tools/build_site.py"


@exits
def docs(
    page: Annotated[
        str, typer.Argument(metavar="PAGE", help="Page to open, such as running or tutorials.")
    ] = "index",
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open a browser or only print the page's address.")
    ] = True,
) -> None:
    """Open the installed documentation."""
    pages, ending = (SITE, ".html") if (SITE / "index.html").is_file() else (SOURCES, ".md")
    if pages is SOURCES and not all((pages / name).is_file() for name in ("index.md", "../pyproject.toml")):
        refuse(
            "docs",
            "this package was built without its documentation",
            str(SITE),
            f"a package with its documentation; in the source code, build it first: {BUILD}",
        )
    if pages is SOURCES:
        complain(f"The site has not been built here, so this is the plain text. To build it: {BUILD}")
    there = {path.relative_to(pages).with_suffix("").as_posix(): path for path in pages.rglob(f"*{ending}")}
    name = page.strip("/").removesuffix(".html").removesuffix(".md")
    alike = [path for key, path in there.items() if key.rpartition("/")[2] == name]
    found = there.get(name) or there.get(f"{name}/index") or (alike[0] if len(alike) == 1 else None)
    if found is None:
        names = [n for n in there if not n.startswith(("source/", "_"))]
        last = {n.rpartition("/")[2]: n for n in names}
        near = get_close_matches(name.rpartition("/")[2], last, 1)
        refuse("PAGE", "no such page", page, "a page such as how-to/running", last[near[0]] if near else "")
    say(found.as_uri())
    if browser and graphical():
        webbrowser.open(found.as_uri())


def graphical() -> bool:
    """Return whether a browser window can be opened here."""
    return not sys.platform.startswith("linux") or bool(
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    )


def list_() -> None:
    """List worlds, sensors, components and systems."""
    sections = {
        "Worlds": titles(),
        "Sensors": dict(_classes(PACKAGE / "config" / "models" / "sensors.py", "kind")),
        "Components": dict(_folder("components")),
        "Systems": dict(_folder("systems", "System")),
    }
    say("\n\n".join(_table(title, rows) for title, rows in sections.items()))


def _folder(name: str, base: str = "") -> list[tuple[str, str]]:
    """Return the public classes in a folder, each with the first line of its docstring."""
    return [row for path in sorted((PACKAGE / name).glob("[!_]*.py")) for row in _classes(path, base=base)]


def _classes(path: Path, label: str = "", base: str = "") -> list[tuple[str, str]]:
    """Return (name, first line) of a file's public classes, or only of the subclasses of `base`; a class
    whose field `label` has a single choice is named after that choice."""
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
