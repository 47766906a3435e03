"""Write layers and sizes into docs/explanation/architecture.md, from contract and docstrings.

    python tools/make_architecture.py [--check]

The contract stands in pyproject.toml, the sizes are those that tools/sizes.py left. --check writes nothing,
and fails where the page is not up to date, or names a file, a class or a function that is not there.
"""

import argparse
import ast
import json
import sys
import textwrap
import tomllib
from html import escape
from pathlib import Path

from doc_names import problems  # the files beside this one
from sizes import exceptions
from sizes import table as sizes_table

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "ecs_eco"
PAGE, PICTURE = ROOT / "docs" / "explanation" / "architecture.md", ROOT / "docs" / "img" / "architecture.svg"
SIZES = ROOT / "studies" / "results" / "sizes.json"
MARKS = ("<!-- rooms: written by tools/make_architecture.py -->", "<!-- end of rooms -->")
SIZE_MARKS = ("<!-- sizes: written by tools/make_architecture.py -->", "<!-- end of sizes -->")
WIDTH, HEIGHT, GAP, LEFT = 860, 38, 6, 44  # [px] of the picture, a layer, between them, beside the arrow


def layers() -> list[list[str]]:
    """Return the rooms of each layer, from top to bottom, as the import contract has them."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (contract,) = (c for c in settings["contracts"] if c["type"] == "layers")
    return [[room.strip() for room in layer.split("|")] for layer in contract["layers"]]


def file_of(room: str) -> Path:
    """Return the file whose docstring says what a room is for."""
    folder = PACKAGE / room
    return folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")


def purpose(room: str) -> tuple[str, str]:
    """Return what belongs to a room, and what does not: the first two paragraphs of its docstring."""
    words = ast.get_docstring(ast.parse(file_of(room).read_text(encoding="utf-8"))) or ""
    first, _, rest = words.partition("\n\n")
    return " ".join(first.split()), " ".join(rest.partition("\n\n")[0].split())


def table(stack: list[list[str]]) -> str:
    """Return a line for each room: its layer, where it is, what it is for and what belongs elsewhere."""
    lines = ["| layer | room | what belongs there | what does not, and what to know |", "|---|---|---|---|"]
    for number, rooms in zip(range(len(stack), 0, -1), stack, strict=True):
        for room in rooms:
            path = PACKAGE / room if (PACKAGE / room).is_dir() else file_of(room)
            is_for, is_not = (text.replace("|", "\\|") for text in purpose(room))
            lines.append(f"| {number} | [{room}](../../{path.relative_to(ROOT)}) | {is_for} | {is_not} |")
    return "\n".join(lines)


def picture(stack: list[list[str]]) -> str:
    """Return the layers as an SVG; rooms beside each other may not import each other either."""
    height = len(stack) * (HEIGHT + GAP) + GAP
    arrow = f"M16 {GAP}V{height - 16}M9 {height - 26}L16 {height - 14}L23 {height - 26}"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
        f'height="{height}" font-family="sans-serif" role="img" aria-label="The layers of ecs_eco">',
        f'<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>',
        f'<path d="{arrow}" fill="none" stroke="#456" stroke-width="2"/>',
        f'<text transform="translate(34 {height / 2}) rotate(-90)" text-anchor="middle" font-size="13" '
        'fill="#456">imports point down only</text>',
    ]
    for number, rooms in enumerate(stack):
        width = (WIDTH - LEFT - GAP * len(rooms)) / len(rooms)
        for place, room in enumerate(rooms):
            parts += _box(room, LEFT + place * (width + GAP), GAP + number * (HEIGHT + GAP), width)
    return "\n".join([*parts, "</svg>\n"])


def _box(room: str, x: float, y: float, width: float) -> list[str]:
    words = purpose(room)[0].replace("`", "").rstrip(".")
    if len(lines := textwrap.wrap(words, int((width - 134) / 6.2))) > 2:
        lines = textwrap.wrap(words.partition(":")[0], int((width - 134) / 6.2))
    first = y + HEIGHT / 2 + (4 if len(lines) == 1 else -3)
    return [
        f'<rect x="{x:g}" y="{y}" width="{width:g}" height="{HEIGHT}" rx="5" fill="#eef3f8" stroke="#9bb"/>',
        f'<text x="{x + 10:g}" y="{y + HEIGHT / 2 + 5:g}" font-size="14" font-weight="bold" fill="#123">'
        f"{escape(room)}</text>",
        *(
            f'<text x="{x + 122:g}" y="{first + 14 * n:g}" font-size="12" fill="#333">{escape(line)}</text>'
            for n, line in enumerate(lines)
        ),
    ]


def sizes() -> str:
    """Return what tools/sizes.py measured: a table, what is above the limits, and the lines of each folder."""
    kept = json.loads(SIZES.read_text(encoding="utf-8"))
    folders = {label: values for label, values in kept["rows"].items() if label.startswith("lines: ")}
    rows = {label: values for label, values in kept["rows"].items() if label not in folders}
    whole = {label: folders[label] for label in folders if label.endswith(", all")}
    folded = f"<details><summary>lines by folder</summary>\n\n{sizes_table(kept, folders)}\n\n</details>"
    return f"{sizes_table(kept, rows | whole)}\n\n{exceptions(kept)}\n\n{folded}"


def between(page: str, marks: tuple[str, str], text: str) -> str:
    """Return a page with another text between two marks."""
    begin, end = (page.index(mark) for mark in marks)
    return f"{page[:begin]}{marks[0]}\n\n{text}\n\n{page[end:]}"


def main() -> int:
    """Write the page and its picture, or say what is not up to date and what is missing."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail where the page is stale")
    check = parser.parse_args().check
    stack, page = layers(), PAGE.read_text(encoding="utf-8")
    page = between(between(page, MARKS, table(stack)), SIZE_MARKS, sizes())
    wanted = {PICTURE: picture(stack), PAGE: page}
    if not check:
        for path, text in wanted.items():
            path.write_text(text, encoding="utf-8")
    there = {path: path.read_text(encoding="utf-8") for path in wanted if path.is_file()}
    stale = [path.name for path, text in wanted.items() if there.get(path) != text]
    wrong = [f"{name} is not up to date: run python tools/make_architecture.py" for name in stale]
    wrong += [f"{PAGE.name}: {what}" for what in problems(PAGE)]
    print("\n".join(wrong), end="\n" * bool(wrong), file=sys.stderr)
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
