"""Find nonexistent names on pages: links, files, modules, classes and functions, and attributes of a world.

    python tools/doc_names.py [PAGE …]

Checks code spans and links; tests run the fenced blocks. Prints the missing names, and exits with 1 if there
are any.
"""

import argparse
import ast
import functools
import os
import re
import sys
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
FORMER = ROOT / "docs" / "reference" / "former_names.md"  # its names no longer exist
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted({*(ROOT / "docs").rglob("*.md")} - {FORMER})]
FOLDERS = {path.name for path in ROOT.iterdir() if path.is_dir()} - {"components", "systems", "genomes"}
ROOMS = {path.name for path in (ROOT / "ecs_eco").iterdir() if path.is_dir()}
YOURS = {"flock.py", "helpers.py", "sir.py"}  # the reader's files, in examples
# names from Python, HTTP and torch
ELSEWHERE = {"Any", "None", "Host", "Origin", "Sequential", "Linear", "Tanh"}
LINK = re.compile(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)")
NAMED_IN = re.compile(r"\]\(([^)#:\s]+\.py)\), `(\w+)`")  # [a file](its path), `what is defined there`
DOTTED = re.compile(r"\b(ecs_eco(?:\.\w+)+)")


def problems(page: Path) -> list[str]:
    """Return a page's nonexistent names, in page order."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    missing = [f"no file {target}" for target in LINK.findall(text) if not (page.parent / target).exists()]
    missing += [
        f"{target} defines no {name}"
        for target, name in NAMED_IN.findall(text)
        if (file := page.parent / target).is_file() and name not in defined(file)
    ]
    for span in dict.fromkeys(re.findall(r"`([^`\n]+)`", text)):
        missing += (f"`{span}`: {what}" for what in _of_span(span))
    return missing


def defined(path: Path) -> set[str]:
    """Return the names of a file's classes, functions, methods and module constants."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    names = {n.name for n in nodes if isinstance(n, ast.FunctionDef | ast.ClassDef)}
    return names | {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


def _of_span(span: str) -> Iterator[str]:
    for dotted in DOTTED.findall(span):
        if not _resolves(dotted):
            yield f"{dotted} does not exist"
    if run := re.match(r"python -m (\w+(?:\.\w+)*)", span):
        if run[1].startswith(("ecs_eco.", "studies.")) and not _is_module(run[1]):
            yield f"no module {run[1]}"
        return
    if owner := re.match(r"(world|World|table)\.(\w+(?:\.\w+)*)", span):
        if not _has(_owner(owner[1]), owner[2].split(".")):
            yield f"{owner[1]} has no {owner[2]}"
        return
    if re.fullmatch(r"[A-Z][a-z]+[A-Za-z0-9]*", span):
        if span not in ELSEWHERE and span not in _all_names():
            yield f"nothing is called {span}"
        return
    path = span.removeprefix("python ").split(" ")[0].partition("::")[0]
    if re.fullmatch(r"[\w./*-]+", path) and not _is_there(path):
        yield f"no file {path}"


@functools.cache
def _all_names() -> frozenset[str]:
    return frozenset().union(*(defined(path) for path in (ROOT / "ecs_eco").rglob("*.py")))


def _is_there(path: str) -> bool:
    """Return whether a file or folder exists; paths outside the project count as existing."""
    first, _, rest = path.partition("/")
    if first in FOLDERS and rest:
        return any(ROOT.glob(path.rstrip("/")))
    if first in ROOMS and rest and not rest.startswith("part-"):  # files in a run folder
        return any((ROOT / "ecs_eco").glob(path.rstrip("/")))
    if path.endswith(".py") and not rest and path not in YOURS:
        tops = ("ecs_eco", "tools", "tests", "examples")
        return any(path in files for top in tops for _, _, files in os.walk(ROOT / top))
    return True


def _is_module(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def _resolves(dotted: str) -> bool:
    """Return whether a dotted name is a module or a member of a module."""
    module, rest = dotted, []
    while not _is_module(module):
        module, _, last = module.rpartition(".")
        rest.insert(0, last)
    return _has(import_module(module), rest)


def _has(owner: Any, names: list[str]) -> bool:
    """Return whether an attribute chain exists; None and attributes set later may have any attribute."""
    for name in names:
        if owner is None:
            return True
        try:
            owner = getattr(owner, name)
        except ModuleNotFoundError:  # it exists, but needs an optional package that is not installed
            return True
        except AttributeError:
            return False
    return True


def _owner(word: str) -> Any:
    from ecs_eco import World
    from ecs_eco.components import Position

    if word == "World":
        return World
    world = World((9.0, 9.0))
    return world.add_table("anybody", Position) if word == "table" else world


def main() -> int:
    """Print missing names; return 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("pages", nargs="*", type=Path, metavar="PAGE")
    sys.path.insert(0, str(ROOT))  # studies are not installed
    pages = parser.parse_args().pages or PAGES
    missing = [f"{page.name}: {what}" for page in pages for what in problems(page)]
    print("\n".join(missing), end="\n" * bool(missing))
    return int(bool(missing))


if __name__ == "__main__":
    sys.exit(main())
