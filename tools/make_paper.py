"""Write docs/paper.md from tools/paper.md: replace each {study | line} by the measured value of that line.

    python tools/make_paper.py [--check]

{study | how a statement begins} is the value of that line of studies/results/study.json,
{bench: name | key=value, … | column} a cell of benchmarks/results/name.json; {goals} and {not met} count over
all studies.
"""

import argparse
import json
import re
import sys
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from make_results import RESULTS, counted, text
from make_tables import show

ROOT = Path(__file__).parents[1]
TEMPLATE, PAGE = Path(__file__).with_name("paper.md"), ROOT / "docs" / "paper.md"
BENCHMARKS = ROOT / "benchmarks" / "results"
PLACE = re.compile(r"\{([^{}\n]+)\}")


def written(template: str) -> str:
    """Return the page. Raises ValueError, with the nearest valid name, if a placeholder names no number."""
    return PLACE.sub(lambda found: number(found.group(1)), template)


def number(place: str) -> str:
    """Return the text that replaces a placeholder."""
    words = [word.strip() for word in place.split("|")]
    if place in ("goals", "not met"):
        return str(total(place))
    if words[0].startswith("bench:"):
        return cell(words[0].removeprefix("bench:").strip(), words[1], words[2])
    return value(*words)


def value(study: str, begins: str, key: str = "value") -> str:
    """Return the measured value, or the goal, of the only line of a study that begins so."""
    record = _read(RESULTS, study)
    lines = {line["statement"]: line for line in record["verdicts"]}
    found = [line for statement, line in lines.items() if statement.startswith(begins)]
    if len(found) != 1:
        near = get_close_matches(begins, lines, 1, 0.3)
        raise ValueError(
            f"{len(found)} lines of {study} begin with {begins!r}"
            + (f"; did you mean {near[0]!r}?" if near else "")
        )
    return text(found[0][key])


def cell(benchmark: str, where: str, column: str) -> str:
    """Return a cell of a benchmark's table, in the first row with these values."""
    rows = _read(BENCHMARKS, benchmark)["rows"]
    wanted = dict(part.strip().split("=") for part in where.split(","))
    for row in rows:
        if all(str(row.get(key)) == given for key, given in wanted.items()):
            if column not in row:
                raise ValueError(f"{benchmark} has no column {column!r}; it has {', '.join(row)}")
            return show(row[column])
    raise ValueError(f"{benchmark} has no row with {where}")


def total(what: str) -> int:
    """Return the number of goals, or of failed goals."""
    records = [json.loads(path.read_text(encoding="utf-8")) for path in RESULTS.glob("*.json")]
    done = [r for r in records if "verdicts" in r and r["complete"] and not r["short"]]
    met, goals = map(sum, zip(*(map(int, counted(record).split(" of ")) for record in done), strict=True))
    return goals if what == "goals" else goals - met


def _read(folder: Path, name: str) -> dict[str, Any]:
    path = folder / f"{name}.json"
    if not path.is_file():
        near = get_close_matches(name, [p.stem for p in folder.glob("*.json")], 1)
        raise ValueError(f"{path} does not exist" + (f"; did you mean {near[0]!r}?" if near else ""))
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content


def main() -> int:
    """Write or check the page."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit with 1 if it is out of date"
    )
    asked = parser.parse_args()
    page = written(TEMPLATE.read_text(encoding="utf-8"))
    if not asked.check:
        PAGE.write_text(page, encoding="utf-8")
    elif not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != page:
        print(f"{PAGE} is out of date: run python tools/make_paper.py", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
