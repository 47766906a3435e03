"""Template fields and the numbers that replace them.

{study | how a statement begins}            the value of that line of studies/results/study.json
{study | how a statement begins | goal}     its goal
{study | how a statement begins | share}    its value "k of n" with Wilson's 95% interval
{study | how a statement begins | passed: words | failed: words}    the words for how it came out
{bench: name | key=value, … | column}       a cell of benchmarks/results/name.json
{goals}, {not met}                          counts over all studies
"""

import json
import re
from collections.abc import Callable
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from cells import shown
from study_pages import RESULTS, counted

from ecs_eco.analysis.survival import wilson

BENCHMARKS = Path(__file__).parents[1] / "benchmarks" / "results"
PLACE = re.compile(r"\{([^{}\n]+)\}")


def written(template: str, more: Callable[[str], str | None] = lambda place: None) -> str:
    """Return the page; `more` may fill fields first. Raises a ValueError for a field without a matching
    number, naming the nearest match."""

    def fill(found: re.Match[str]) -> str:
        own = more(found.group(1))
        return number(found.group(1)) if own is None else own

    return PLACE.sub(fill, template)


def number(place: str) -> str:
    """Return a field's text."""
    words = [word.strip() for word in place.split("|")]
    if place in ("goals", "not met"):
        return str(total(place))
    if words[0].startswith("bench:"):
        return cell(words[0].removeprefix("bench:").strip(), words[1], words[2])
    if len(words) < 2:
        raise ValueError(f"{{{place}}} matches no number: write {{study | how a statement begins}}")
    return value(*words)


def value(study: str, begins: str, key: str = "value", other: str = "") -> str:
    """Return the value, the goal or the words for the outcome from the only line of a study that begins with
    these words."""
    record = read_result(RESULTS, study)
    lines = {line["statement"]: line for line in record["verdicts"]}
    found = [line for statement, line in lines.items() if statement.startswith(begins)]
    if len(found) != 1:
        near = get_close_matches(begins, lines, 1, 0.3)
        raise ValueError(
            f"{len(found)} lines of {study} begin with {begins!r}"
            + (f"; did you mean {near[0]!r}?" if near else "")
        )
    if other:
        words = dict(part.split(":", 1) for part in (key, other))
        return words["passed" if found[0]["met"] else "failed"].strip()
    if key == "share":
        return share(found[0])
    return shown(found[0][key])


def share(line: dict[str, Any]) -> str:
    """Return a count with Wilson's interval; the value is "k of n", or k if the statement ends with "of
    n"."""
    count, statement = str(line["value"]), line["statement"]
    found = re.match(r"(\d+) of (\d+)", count) or re.search(r"^(\d+)\n.*of (\d+)$", f"{count}\n{statement}")
    if found is None:
        raise ValueError(f"{statement!r}: {count!r} is not a count of runs")
    k, n = map(int, found.groups())
    return "{} of {} ({:.0%} to {:.0%})".format(k, n, *wilson(k, n)[1:])


def cell(benchmark: str, where: str, column: str) -> str:
    """Return a cell of a benchmark's table, from the first row with these values."""
    rows = read_result(BENCHMARKS, benchmark)["rows"]
    wanted = dict(part.strip().split("=") for part in where.split(","))
    for row in rows:
        if all(str(row.get(key)) == given for key, given in wanted.items()):
            if column not in row:
                raise ValueError(f"{benchmark} has no column {column!r}; it has {', '.join(row)}")
            return show(row[column])
    raise ValueError(f"{benchmark} has no row with {where}")


def show(number: Any) -> str:
    """Return a benchmark value as a cell."""
    if isinstance(number, bool):
        return "yes" if number else "no"
    if isinstance(number, int):
        return f"{number:,}"
    if isinstance(number, float):
        return f"{number:,.0f}" if abs(number) >= 100 else f"{number:.3g}"
    return str(number)


def total(what: str) -> int:
    """Return the number of goals, or of failed goals."""
    records = [json.loads(path.read_text(encoding="utf-8")) for path in RESULTS.glob("*.json")]
    done = [r for r in records if "verdicts" in r and r["complete"] and not r["short"]]
    met, goals = map(sum, zip(*(map(int, counted(record).split(" of ")) for record in done), strict=True))
    return goals if what == "goals" else goals - met


def read_result(folder: Path, name: str) -> dict[str, Any]:
    """Return a stored result. Raises a ValueError for a missing result, with the nearest name."""
    path = folder / f"{name}.json"
    if not path.is_file():
        near = get_close_matches(name, [p.stem for p in folder.glob("*.json")], 1)
        raise ValueError(f"{path} does not exist" + (f"; did you mean {near[0]!r}?" if near else ""))
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content
