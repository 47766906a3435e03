"""Print the code size at one or more commits: functions, files, folders, and `Any` in signatures.

    python tools/sizes.py [COMMIT …] [--out studies/results/sizes.json]

Prints a Markdown table with a column for each commit (default: HEAD), then the exceptions at the last commit:
files of more than 300 lines and functions of more than 50. --out stores both as JSON.

A line of code is a row in which a statement begins, a docstring row, or a comment on its own row; wrapped and
empty rows do not count. Docstring sections (Parameters, Returns, Examples …) are the API reference, not code,
and do not count.
"""

import argparse
import ast
import io
import json
import re
import statistics
import subprocess
import sys
import tarfile
import tokenize
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).parents[1]
PACKAGE = "ecs_eco"
FILE_LIMIT, FUNCTION_LIMIT = 300, 50  # [lines of code]
REASONS = {  # reasons for exceptions
    "ecs_eco/space/nearest.py::seek": "one kernel: its loops over cells and lanes share what they count"
}
SECTION = re.compile(r"\n\s*\n *[A-Z]\w+\n *-{3,}\n")  # the heading of a docstring section
LAYOUT = {tokenize.INDENT, tokenize.DEDENT, tokenize.NL, tokenize.ENDMARKER}
Function = ast.FunctionDef | ast.AsyncFunctionDef


class Size(NamedTuple):
    """Line counts for each file in a commit and each function in the package, and the `Any` annotations."""

    files: dict[str, int]
    functions: dict[str, int]  # by path::name, from `def` to the last line
    rows: dict[str, int]  # physical rows of each file
    annotations: int  # annotations of parameters and results in the package
    any_alone: int  # of these `Any`
    any_within: int  # those containing `Any`, as in list[Any]

    @property
    def package(self) -> dict[str, int]:
        """The numbers of lines of the package's files, by path."""
        return {path: n for path, n in self.files.items() if path.startswith(f"{PACKAGE}/")}


def measure(sources: dict[str, str]) -> Size:
    """Return file sizes, by path."""
    functions: dict[str, int] = {}
    notes: list[ast.expr] = []
    lines: dict[str, int] = {}
    for path, text in sources.items():
        of_code = code_lines(text)
        lines[path] = len(of_code)
        if path.startswith(f"{PACKAGE}/"):
            for name, node in functions_of(ast.parse(text)):
                functions[f"{path}::{name}"] = within(of_code, node)
                notes += annotations_of(node)
    with_any = [note for note in notes if "Any" in (n.id for n in ast.walk(note) if isinstance(n, ast.Name))]
    alone = sum(isinstance(note, ast.Name) for note in with_any)
    rows = {path: len(text.splitlines()) for path, text in sources.items()}
    return Size(lines, functions, rows, len(notes), alone, len(with_any) - alone)


def code_lines(text: str) -> list[int]:
    """Return the rows in which statements begin, and the rows of docstrings and standalone comments."""
    rows: list[int] = []
    begun = False
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.NEWLINE:
            begun = False
        elif not begun and token.type not in LAYOUT:
            rows += range(token.start[0], token.start[0] + _height(token))
            begun = token.type != tokenize.COMMENT
    return rows


def _height(token: tokenize.TokenInfo) -> int:
    """Return the number of rows that a token counts as; a string counts only up to its first section."""
    if token.type != tokenize.STRING:
        return 1
    section = SECTION.search(token.string)
    return token.string[: section.start() if section else None].count("\n") + 1


def within(rows: list[int], node: Function) -> int:
    """Return how many of the rows, given in ascending order, belong to a function."""
    return bisect_right(rows, node.end_lineno or 0) - bisect_left(rows, node.lineno)


def functions_of(node: ast.AST, within: str = "") -> Iterator[tuple[str, Function]]:
    """Yield all functions and methods below a node, by dotted name."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.expr):  # contains no function; skipping these is several times faster
            continue
        named = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        name = f"{within}{child.name}" if named else within
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            yield name, child
        yield from functions_of(child, f"{name}." if named else within)


def annotations_of(node: Function) -> list[ast.expr]:
    """Return the annotations of a function's parameters and result; strings are parsed."""
    a = node.args
    arguments = (*a.posonlyargs, *a.args, a.vararg, *a.kwonlyargs, a.kwarg)
    notes = [note for note in (*(one.annotation for one in arguments if one), node.returns) if note]
    texts = [note.value if isinstance(note, ast.Constant) else None for note in notes]
    return [
        ast.parse(text, mode="eval").body if isinstance(text, str) else note
        for note, text in zip(notes, texts, strict=True)
    ]


def full(commit: str) -> str:
    """Return a commit's full hash."""
    return subprocess.run(
        ["git", "rev-parse", commit], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True
    ).stdout.strip()


def sources_of(commit: str) -> dict[str, str]:
    """Return the Python files in a commit, by path; links to folders are skipped."""
    packed = subprocess.run(["git", "archive", commit], cwd=ROOT, stdout=subprocess.PIPE, check=True).stdout
    sources = {}
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        for member in archive:
            if member.isfile() and member.name.endswith(".py") and (file := archive.extractfile(member)):
                sources[member.name] = file.read().decode()
    return sources


def rows_of(size: Size) -> dict[str, str]:
    """Return the table column for one commit: label → value."""
    functions, files = sorted(size.functions.values()), list(size.package.values())
    p90 = functions[int(0.9 * (len(functions) - 1))]
    rows = {
        "functions: number": f"{len(functions):,}",
        "functions: median, 90 %, most lines": f"{statistics.median(functions):g}, {p90}, {functions[-1]}",
        f"functions of more than {FUNCTION_LIMIT} lines": str(sum(n > FUNCTION_LIMIT for n in functions)),
        "files: number": str(len(files)),
        "files: median, most lines": f"{statistics.median(files):g}, {max(files)}",
        f"files of more than {FILE_LIMIT} lines": str(sum(n > FILE_LIMIT for n in files)),
        "annotations of parameters and results": f"{size.annotations:,}",
        "… that are `Any`": str(size.any_alone),
        "… with `Any` within": str(size.any_within),
    }
    folders: dict[str, int] = {}
    for path, lines in size.files.items():
        top, *rest = path.split("/")
        folder = f"{top}/{rest[0]}" if top == PACKAGE and len(rest) > 1 else top if rest else "."
        folders[folder] = folders.get(folder, 0) + lines
        if top == PACKAGE:
            folders[f"{top}, all"] = folders.get(f"{top}, all", 0) + lines
    return rows | {f"lines: {folder}": f"{lines:,}" for folder, lines in sorted(folders.items())}


def summary(sizes: dict[str, Size]) -> dict[str, Any]:
    """Return the stored summary: the commits, a table column for each, and the exceptions at the last
    commit."""
    columns = [rows_of(size) for size in sizes.values()]
    labels = list(dict.fromkeys(label for column in columns for label in column))
    # labels of all commits, in a common order
    labels.sort(key=lambda label: label if label.startswith("lines: ") else "")
    last = list(sizes.values())[-1]
    over = [(name, lines) for name, lines in last.package.items() if lines > FILE_LIMIT]
    over += [(name, lines) for name, lines in last.functions.items() if lines > FUNCTION_LIMIT]
    return {
        "commits": list(sizes),
        "rows": {label: [column.get(label, "–") for column in columns] for label in labels},
        "limits": {"file": FILE_LIMIT, "function": FUNCTION_LIMIT},
        "over": [{"name": name, "lines": lines, "reason": REASONS.get(name, "open")} for name, lines in over],
    }


def table(kept: dict[str, Any], rows: dict[str, list[str]]) -> str:
    """Return rows as a Markdown table with a column for each commit."""
    cells = [["", *(commit[:7] for commit in kept["commits"])], ["---"] * (len(kept["commits"]) + 1)]
    return "\n".join(
        f"| {' | '.join(row)} |" for row in [*cells, *([label, *values] for label, values in rows.items())]
    )


def exceptions(kept: dict[str, Any]) -> str:
    """Return the exceptions as text."""
    limits = f"Above {kept['limits']['file']} lines a file, or {kept['limits']['function']} a function: "
    return (
        limits
        + ("; ".join(f"`{one['name']}`, {one['lines']} ({one['reason']})" for one in kept["over"]) or "none")
        + "."
    )


def main() -> int:
    """Print the table and the exceptions."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("commits", nargs="*", default=["HEAD"], metavar="COMMIT")
    parser.add_argument("--out", type=Path, metavar="FILE")
    given = parser.parse_args()
    kept = summary({full(commit): measure(sources_of(commit)) for commit in given.commits})
    print(f"{table(kept, kept['rows'])}\n\n{exceptions(kept)}")
    if given.out is not None:
        given.out.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
