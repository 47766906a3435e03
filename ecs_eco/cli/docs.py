"""The command docs: these pages, from the copy that came with the package, or from a copy of the sources."""

from __future__ import annotations

import os
import sys
import webbrowser
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated

import typer

import ecs_eco
from ecs_eco.cli.terminal import complain, exits, refuse, say

SITE = Path(ecs_eco.__file__).parent / "_site"  # tools/build_site.py writes it, and the wheel takes it
SOURCES = Path(ecs_eco.__file__).parents[1] / "docs"  # in a copy of the sources
BUILD = "pip install -e '.[docs]' && python tools/build_site.py"


@exits
def docs(
    page: Annotated[
        str, typer.Argument(metavar="PAGE", help="A page, such as running, or tutorials.")
    ] = "index",
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open a browser, or only print where the page is.")
    ] = True,
) -> None:
    """Open the documentation, from the copy on this machine."""
    pages, ending = (SITE, ".html") if (SITE / "index.html").is_file() else (SOURCES, ".md")
    if pages is SOURCES and not all((pages / name).is_file() for name in ("index.md", "../pyproject.toml")):
        refuse(
            "docs",
            "this package was built without its pages",
            str(SITE),
            f"the folder docs of its sources; or there, before the package is built: {BUILD}",
        )
    if pages is SOURCES:
        complain(f"The site is not built in this copy of the sources; this is its text. Build it: {BUILD}")
    there = {path.relative_to(pages).with_suffix("").as_posix(): path for path in pages.rglob(f"*{ending}")}
    name = page.strip("/").removesuffix(".html").removesuffix(".md")
    found = there.get(name) or there.get(f"{name}/index") or _only(name, there)
    if found is None:
        names = [n for n in there if not n.startswith(("source/", "_"))]
        last = {n.rpartition("/")[2]: n for n in names}
        near = get_close_matches(name.rpartition("/")[2], last, 1)
        refuse(
            "PAGE",
            "there is no such page",
            page,
            "a page of the site, such as how-to/running",
            last[near[0]] if near else "",
        )
    say(found.as_uri())
    if browser and _graphical():
        webbrowser.open(found.as_uri())


def _only(name: str, there: dict[str, Path]) -> Path | None:
    """The page whose last part is the name, if there is one alone."""
    same = [path for key, path in there.items() if key.rpartition("/")[2] == name]
    return same[0] if len(same) == 1 else None


def _graphical() -> bool:
    return not sys.platform.startswith("linux") or bool(
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    )
