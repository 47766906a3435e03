"""Find words and phrases that a native author would not write, in pages, docstrings, comments and program
texts.

    python tools/plain_words.py [FILE or FOLDER …]  [--count]

Prints FILE:LINE, the words found and a replacement, and exits with 1 if there are any.
`tools/plain_words.toml` lists the rules. Code, code spans and quoted text are ignored. So are evidence pages
and labels of registered or stored results, which cannot change, and the shipped worlds' code, which their
hashes cover.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import sys
import tokenize
import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
STUDIES = ROOT / "studies"
PLACES = (
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "docs",
    "ecs_eco",
    "examples",
    "studies",
    "benchmarks",
    "tools",
)
BLANKS = re.compile(
    r"```.*?^```$|\{[^{}\n]*\}|`[^`\n]*`|\[\^?[^\]]*\]:.*$|\]\([^)]*\)|<[^>]*>|https?://\S+|\"[^\"\n]{1,60}\"",
    re.M | re.S,
)

STRING = re.compile(r"\"([^\"]+)\"|`([^`]+)`|>(\w[^<>\"`]+)<")  # on one line of TOML, JS or HTML


@dataclass(frozen=True)
class Rule:
    """A pattern, what to write instead, and the kinds of text that it applies to."""

    find: re.Pattern[str]
    instead: str
    kinds: frozenset[str]


def rules() -> list[Rule]:
    """Return the rules of plain_words.toml, in its order."""
    table = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    return [
        Rule(
            re.compile(rule["find"], re.M | re.I * (not rule.get("case", False))),
            rule["instead"],
            frozenset(rule.get("in", ["page", "docstring", "comment", "text"])),
        )
        for rule in table["rule"]
    ]


def texts(path: Path) -> Iterator[tuple[int, str, str]]:
    """Yield the first line, kind and content of each human-readable text in a file."""
    content, suffix = path.read_text(encoding="utf-8"), _suffix(path)
    if suffix == ".md":
        yield 1, "page", content
    elif suffix == ".py":
        yield from _of_python(content)
    elif suffix in {".toml", ".js", ".html"}:
        comment = re.compile(r"#+ (.*)" if suffix == ".toml" else r"(?:^\s*/?\*\*?|//) (.*)|<!-- (.*) -->")
        for number, row in enumerate(content.splitlines(), 1):
            for string in STRING.finditer(row):
                words = re.sub(r"\$?\{[^{}]*\}", "…", string[string.lastindex or 0])
                if not re.search(r"[<>={}_&|]", words) and len(re.findall(r"[a-z]+\b.? ", words)) >= 3:
                    yield number, "text", words
            if found := comment.search(row):
                said = next(filter(None, found.groups()), "")
                said = re.sub(
                    r"@\w+( \{.*\})?( \[?[\w.]+\]?)?|\w+: (\w+|\(.*\) => \w+)[;,}]", "", said
                )  # types
                yield number, "comment", said


def _suffix(path: Path) -> str:
    return Path(path.name.removesuffix(".template")).suffix


def _of_python(content: str) -> Iterator[tuple[int, str, str]]:
    tree = ast.parse(content)
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    docstrings = {
        id(node.body[0].value): "function" if isinstance(node, ast.FunctionDef) else "class"
        for node in ast.walk(tree)
        if isinstance(node, documented) and ast.get_docstring(node)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            if id(node) in docstrings:
                yield (
                    node.lineno,
                    "docstring",
                    re.sub(r"^ *(>>>|\.\.\.|\w+ : ).*$", "", node.value, flags=re.M),
                )
            elif len(re.findall(r"\b[a-z]{2,} ", node.value)) >= 2:
                yield node.lineno, "text", node.value
    for token in tokenize.generate_tokens(io.StringIO(content).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], "comment", token.string.lstrip("# ")


@cache
def stored() -> str:
    """Return all results and registrations of studies, whose labels cannot change."""
    return "".join(p.read_text(encoding="utf-8") for p in STUDIES.glob("re*/*.*"))


def findings(path: Path, among: list[Rule]) -> Iterator[tuple[int, str, str]]:
    """Yield the line, words and advice for each rule violation in a file."""
    for first, kind, text in texts(path):
        prose = BLANKS.sub(lambda gap: re.sub(r"[^\n]", "¤", gap[0]), text)
        for rule in among:
            if kind in rule.kinds:
                for found in rule.find.finditer(prose):
                    if kind == "text" and "studies" in path.parts and text in stored():
                        break
                    yield first + prose.count("\n", 0, found.start()), found[0].strip(), rule.instead


def files(places: list[Path]) -> Iterator[Path]:
    """Yield the files with texts at or below the given paths."""
    for place in places:
        inside = sorted(p for p in place.rglob("*") if _suffix(p) in {".md", ".py", ".toml", ".js", ".html"})
        yield from (
            [
                p
                for p in inside
                if not {"_site", "__pycache__", "evidence", "registered", "results", "results.md"}
                & set(p.parts)
                and "vendor" not in p.name
                and not (p.suffix == ".py" and "worlds" in p.parts)
            ]
            if place.is_dir()
            else [place]
        )


def main() -> int:
    """Print the findings, or their number by rule; return 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("places", nargs="*", type=Path, metavar="FILE")
    parser.add_argument("--count", action="store_true", help="print only how often each rule is violated")
    asked = parser.parse_args()
    among, counts, wheres = rules(), Counter[str](), Counter[str]()
    for path in files(asked.places or [ROOT / place for place in PLACES]):
        for line, words, instead in findings(path, among):
            counts[instead] += 1
            wheres["/".join(path.parts[-3:-1])] += 1
            if not asked.count:
                print(f"{path}:{line}: {words!r}: write {instead}")
    if asked.count:
        print("\n".join(f"{n:5} {what}" for what, n in counts.most_common()))
        print("\n".join(f"{n:5} {what}" for what, n in wheres.most_common(40)))
    print(f"{counts.total()} findings", file=sys.stderr)
    return int(counts.total() > 0)


if __name__ == "__main__":
    sys.exit(main())
