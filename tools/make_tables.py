"""Write docs/benchmarks.md (from tools/benchmarks.md), its chart, benchmarks/NOTES.md and the table in
docs/explanation/speed.md, all from benchmarks/results; with --check, only compare.

python tools/make_tables.py [--check]
"""

import argparse
import json
import sys
import tomllib
from pathlib import Path
from typing import Any

import cost  # files in this folder
from cells import typeset
from fields import show, written
from peers_chart import chart
from speed_goals import goals

ROOT = Path(__file__).parents[1]
BENCHMARKS, TEMPLATE = ROOT / "benchmarks", Path(__file__).with_name("benchmarks.md")
PAGE, NOTES = ROOT / "docs" / "benchmarks.md", BENCHMARKS / "NOTES.md"
SPEED = ROOT / "docs" / "explanation" / "speed.md"
ADDED = tomllib.loads((BENCHMARKS / "notes.toml").read_text(encoding="utf-8"))
CHART, CHARTED = ROOT / "docs" / "img" / "speed_against_peers.svg", 10_000  # animals
TOCTREE = "\n```{toctree}\n:hidden:\n\n/project/benchmarks\n```\n"
MARKS = ("<!-- table: {} -->", "<!-- end of table -->")
HEAD = """# All measurements of speed

<!-- Written by tools/make_tables.py from benchmarks/: change its results and *.toml, not this page. -->

[How fast it is](../docs/benchmarks.md) summarizes these tables. Machines are shared and noisy: trust ratios
within one run; an individual time can be off by half. "Load" is the load on all cores when a benchmark ended;
with more processes than cores, all times are too long. "Before" and "now" in one table took turns on the same
machine. Time ratios below 1 are gains.

## Goals

From `goals.toml`. Goals were set from times on another machine, so the last columns also compare gains: the
goal divided by the time when it was set (for a range, the end farther from the goal), and "now" divided by
"before" (the median over turns).
"""
DROPPED = """## Tried and dropped

Each attempt is listed once, from `notes.toml`. Times are relative to the shipped code.
"""


def read() -> dict[str, dict[str, Any]]:
    """Return all results that answer a question, by name, in page order."""
    order = list(ADDED["headings"])
    results = {p.stem: json.loads(p.read_text()) for p in (BENCHMARKS / "results").glob("*.json")}
    asked = [name for name, result in results.items() if "question" in result]
    return {n: results[n] for n in sorted(asked, key=lambda n: (order.index(n) if n in order else 99, n))}


def page(results: dict[str, dict[str, Any]]) -> str:
    """Return the short page."""

    def own(place: str) -> str | None:
        kind, _, rest = place.partition(":")
        words = [word.strip() for word in rest.split("|")]
        if kind == "cost":
            return cost.number(*words)
        if kind == "machine":
            return machine(results[words[0]])
        if kind == "times":
            return times(results["peers"]["rows"], words[0], words[1], int(words[2]))
        return cost.costs() if place == "costs" else None

    return written(TEMPLATE.read_text(encoding="utf-8"), own) + TOCTREE


def times(rows: list[dict[str, Any]], one: str, other: str, animals: int) -> str:
    """Return how many times as fast one peer is as another, to two significant digits."""
    speed = {row["peer"]: row["k organism-steps/s"] for row in rows if row["animals"] == animals}
    ratio = speed[one] / speed[other]
    return f"{float(f'{ratio:.2g}'):,g}"


def notes(results: dict[str, dict[str, Any]]) -> str:
    """Return the page that lists every result, and each attempt once."""
    parts = [HEAD, f"{goals(BENCHMARKS / 'results')}\n"]
    parts += [
        f"## {heading(name, result)}\n\n{measured(name, result, '../docs/img')}\n"
        for name, result in results.items()
    ]
    parts.append(DROPPED)
    for area, attempts in ADDED["attempts"].items():
        lines = "\n".join(f"- {what}: {came}" for what, came in attempts.items())
        parts.append(f"### {area.capitalize()}\n\n{lines}\n")
    return "\n".join(parts)


def heading(name: str, result: dict[str, Any]) -> str:
    """Return a result's heading, by default its question."""
    return str(ADDED["headings"].get(name) or typeset(result["question"]))


def measured(name: str, result: dict[str, Any], images: str) -> str:
    """Return a result's command, table, figure, notes and machine."""
    drawn = PAGE.parent / "img" / f"{name}.svg"
    figure = f"\n![{heading(name, result)}]({images}/{drawn.name})\n" if drawn.is_file() else ""
    said = {k: v for k, v in result["notes"].items() if not k.startswith("tried")}  # in notes.toml
    lines = "".join(f"\n- {typeset(k)}: {typeset(show(v))}" for k, v in said.items())
    command = f"`python benchmarks/{script(name)}.py` ({name})"
    return f"{command}\n\n{table(result['rows'])}\n{figure}{lines}\n\n{machine(result)}.".replace(
        "\n\n\n", "\n\n"
    )


def machine(result: dict[str, Any]) -> str:
    """Return a result's machine, commit and versions."""
    m = result["machine"]
    versions = ", ".join(f"{k} {v}" for k, v in m["versions"].items() if v != "not installed")
    commit = (m["commit"] or "unknown")[:12]
    return f"{m['processor']}, {m['cores']} cores, load {m['load']}; commit `{commit}`; {versions}"


def table(rows: list[dict[str, Any]]) -> str:
    """Return rows as a Markdown table."""
    head = list(rows[0])
    lines = ["| " + " | ".join(typeset(h) for h in head) + " |", "|" + "---|" * len(head)]
    cells = [[typeset(show("–" if r.get(h, "") is None else r.get(h, ""))) for h in head] for r in rows]
    return "\n".join([*lines, *("| " + " | ".join(line) + " |" for line in cells)])


def script(name: str) -> str:
    """Return the script that wrote a result: the longest script name with which the result's name begins."""
    return max((p.stem for p in BENCHMARKS.glob("*.py") if name.startswith(p.stem)), key=len)


def within(path: Path, results: dict[str, dict[str, Any]], *names: str) -> str:
    """Return a page's content with the tables of some results between their marks."""
    content = path.read_text()
    for name in names:
        mark = MARKS[0].format(name)
        begin = content.index(mark) + len(mark)
        end = content.index(MARKS[1], begin)
        content = f"{content[:begin]}\n{measured(name, results[name], '../img')}\n{content[end:]}"
    return content


def main() -> int:
    """Write or compare the pages."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--check", action="store_true")
    results = read()
    wanted = {
        PAGE: page(results),
        CHART: chart(results["peers"]["rows"], CHARTED),
        NOTES: notes(results),
        SPEED: within(SPEED, results, "ablations", "pairs_all", "main_job_between", "two_worlds"),
    }
    if parser.parse_args().check:
        stale = [path.name for path, text in wanted.items() if not path.is_file() or path.read_text() != text]
        if stale:
            print(
                f"{', '.join(stale)}: differs from benchmarks/results; run python tools/make_tables.py",
                file=sys.stderr,
            )
        return bool(stale)
    for path, text in wanted.items():
        path.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
