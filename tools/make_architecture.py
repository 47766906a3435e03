"""Write the layers to docs/explanation/architecture.md, from the import contract and docstrings.

    python tools/make_architecture.py [--check]

The contract is in pyproject.toml. --check writes nothing and fails if the page is out of date or names a file,
class or function that does not exist.
"""

import argparse
import ast
import sys
import textwrap
import tomllib
from html import escape
from pathlib import Path

from doc_names import problems  # tools/doc_names.py

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "ecs_eco"
PAGE, PICTURE = ROOT / "docs" / "explanation" / "architecture.md", ROOT / "docs" / "img" / "architecture.svg"
MARKS = ("<!-- packages: written by tools/make_architecture.py -->", "<!-- end of packages -->")
WIDTH, HEIGHT, GAP, LEFT = 860, 38, 6, 44  # [px]: picture, layer, gap between layers, space for the arrow


def layers() -> list[list[str]]:
    """Return the packages in each layer of the import contract, from top to bottom."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (contract,) = (c for c in settings["contracts"] if c["type"] == "layers")
    return [[package.strip() for package in layer.split("|")] for layer in contract["layers"]]


def file_of(package: str) -> Path:
    """Return the file whose docstring describes a package."""
    folder = PACKAGE / package
    return folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")


def purpose(package: str) -> tuple[str, str]:
    """Return the first two paragraphs of a package's docstring: what belongs there and what does not."""
    words = ast.get_docstring(ast.parse(file_of(package).read_text(encoding="utf-8"))) or ""
    first, _, rest = words.partition("\n\n")
    return " ".join(first.split()), " ".join(rest.partition("\n\n")[0].split())


def table(stack: list[list[str]]) -> str:
    """Return a row for each package: layer, link, contents and notes."""
    lines = ["| layer | package | contents | notes |", "|---|---|---|---|"]
    for number, packages in zip(range(len(stack), 0, -1), stack, strict=True):
        for package in packages:
            path = PACKAGE / package if (PACKAGE / package).is_dir() else file_of(package)
            is_for, is_not = (text.replace("|", "\\|") for text in purpose(package))
            lines.append(f"| {number} | [{package}](../../{path.relative_to(ROOT)}) | {is_for} | {is_not} |")
    return "\n".join(lines)


def picture(stack: list[list[str]]) -> str:
    """Return the layers as an SVG; packages in the same layer must not import each other."""
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
    for number, packages in enumerate(stack):
        width = (WIDTH - LEFT - GAP * len(packages)) / len(packages)
        for place, package in enumerate(packages):
            parts += _box(package, LEFT + place * (width + GAP), GAP + number * (HEIGHT + GAP), width)
    return "\n".join([*parts, "</svg>\n"])


def _box(package: str, x: float, y: float, width: float) -> list[str]:
    words = purpose(package)[0].replace("`", "").rstrip(".")
    if len(lines := textwrap.wrap(words, int((width - 134) / 6.2))) > 2:
        lines = textwrap.wrap(words.partition(":")[0], int((width - 134) / 6.2))
    first = y + HEIGHT / 2 + (4 if len(lines) == 1 else -3)
    return [
        f'<rect x="{x:g}" y="{y}" width="{width:g}" height="{HEIGHT}" rx="5" fill="#eef3f8" stroke="#9bb"/>',
        f'<text x="{x + 10:g}" y="{y + HEIGHT / 2 + 5:g}" font-size="14" font-weight="bold" fill="#123">'
        f"{escape(package)}</text>",
        *(
            f'<text x="{x + 122:g}" y="{first + 14 * n:g}" font-size="12" fill="#333">{escape(line)}</text>'
            for n, line in enumerate(lines)
        ),
    ]


def between(page: str, marks: tuple[str, str], text: str) -> str:
    """Return a page with the text between two marks replaced."""
    begin, end = (page.index(mark) for mark in marks)
    return f"{page[:begin]}{marks[0]}\n\n{text}\n\n{page[end:]}"


def main() -> int:
    """Write the page and its picture; print outdated or missing items."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if the page is out of date")
    check = parser.parse_args().check
    stack, page = layers(), PAGE.read_text(encoding="utf-8")
    page = between(page, MARKS, table(stack))
    wanted = {PICTURE: picture(stack), PAGE: page}
    if not check:
        for path, text in wanted.items():
            path.write_text(text, encoding="utf-8")
    there = {path: path.read_text(encoding="utf-8") for path in wanted if path.is_file()}
    stale = [path.name for path, text in wanted.items() if there.get(path) != text]
    wrong = [f"{name} is out of date: run python tools/make_architecture.py" for name in stale]
    wrong += [f"{PAGE.name}: {what}" for what in problems(PAGE)]
    print("\n".join(wrong), end="\n" * bool(wrong), file=sys.stderr)
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
