"""The command docs: these pages, from the copy that came with the package."""

from __future__ import annotations

import os
import sys
import webbrowser
from difflib import get_close_matches
from pathlib import Path

import ecs_eco
from ecs_eco.cli.terminal import refuse, say

SITE = Path(ecs_eco.__file__).parent / "_site"  # tools/build_site.py writes it; it is in the wheel


def open_docs(page: str, browser: bool) -> None:
    """Print where a page is, and open it in a graphical browser where there is one."""
    if not (SITE / "index.html").is_file():
        refuse("docs", "the pages are not built in this copy of the sources", str(SITE),
               "pip install -e '.[docs]' && python tools/build_site.py; or read docs/")
    there = {path.relative_to(SITE).with_suffix("").as_posix(): path for path in SITE.rglob("*.html")}
    name = page.strip("/").removesuffix(".html").removesuffix(".md")
    found = there.get(name) or there.get(f"{name}/index") or _only(name, there)
    if found is None:
        names = [n for n in there if not n.startswith(("source/", "_"))]
        last = {n.rpartition("/")[2]: n for n in names}
        near = get_close_matches(name.rpartition("/")[2], last, 1)
        refuse("PAGE", "there is no such page", page, "a page of the site, such as how-to/running",
               last[near[0]] if near else "")
    say(found.as_uri())
    if browser and _graphical():
        webbrowser.open(found.as_uri())


def _only(name: str, there: dict[str, Path]) -> Path | None:
    """The page whose last part is the name, if there is one alone."""
    same = [path for key, path in there.items() if key.rpartition("/")[2] == name]
    return same[0] if len(same) == 1 else None


def _graphical() -> bool:
    return not sys.platform.startswith("linux") or bool(
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
