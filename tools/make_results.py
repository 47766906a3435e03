"""Write docs/results.md from studies/results/*.json: each claim, what was measured,
and how to measure it again.

python tools/make_results.py            writes the file
python tools/make_results.py --check    fails where the file is not what the results say
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from persistence import opening  # the file beside this one

ROOT = Path(__file__).parent.parent
RESULTS = ROOT / "studies" / "results"
PAGE = ROOT / "docs" / "results.md"
NEEDED: tuple[str, ...] = ("name", "claim", "complete", "short", "command", "verdicts", "cases",
                           "seeds", "seconds")
NEEDED += ("commits", "dirty", "config_hash", "versions")
HEAD = """# Results

<!-- Written by tools/make_results.py from studies/results/*.json: change those, not this page. -->

Each claim has one script that tests it. Seeds are the replicates; a goal that was not met stays here. \
What is told of worlds opens
with the share of runs in which all persisted, an arm in which they were meant to die out included.
"""

SINCE = {  # what has changed since the commits at which a study was run, as far as it touches its figures
    "diel_migration": "Measured before krill lost their energy budget (commit `908e4ca`), which fell below 0 "
    "and meant nothing. Copepods and phytoplankton then lived as before to the last bit, in three runs of "
    "1,500 ticks, so their figures stand; any of the energy of krill are of the earlier world. The short "
    "form ran through afterwards; the long one was not run again.",
    "learning_krill": "Measured before krill that hunt by the written reflex lost their energy budget "
    "(commit `908e4ca`). Krill that learn have one as before; the arm of the written reflex is of the "
    "earlier world, in which the full did not eat. The short form ran through afterwards; the long one was "
    "not run again.",
}


def text(x: Any) -> str:
    """A value for a cell of a Markdown table."""
    if x is None:
        return "–"
    if isinstance(x, bool):
        return "yes" if x else "no"
    if isinstance(x, float):
        return f"{x:.3g}" if abs(x) < 1000 else f"{x:,.0f}"
    if isinstance(x, list):
        numbers = all(isinstance(v, int | float) for v in x)
        return (f"{text(x[0])} ({text(x[1])} … {text(x[2])})" if len(x) == 3
                and numbers else ", ".join(map(text, x)))
    return str(x).replace("|", "\\|").replace("\n", " ")


def table(head: list[str], rows: list[list[Any]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(text(x) for x in line) + " |" for line in lines)


def section(record: dict[str, Any]) -> str:
    """One study: claim, verdicts, table and where they come from."""
    met = sum(line["met"] for line in record["verdicts"])
    rows = [
        ["met" if line["met"] else "**not met**", line["statement"], line["value"], line["goal"]]
        for line in record["verdicts"]
    ]
    blocks = [
        f"## {record['name']}",
        record["claim"],
        *([f"**{summary}**"] if (summary := opening(record)) else []),
        f"{met} of {len(rows)} goals met.",
        table(["", "statement", "measured", "goal"], rows),
    ]
    if record.get("table"):
        blocks.append(table(record["table"]["head"], record["table"]["rows"]))
    if record.get("notes"):
        blocks.append(record["notes"])
    if record["name"] in SINCE:
        blocks.append(SINCE[record["name"]])
    commits = ", ".join(f"`{c[:12]}`" for c in record["commits"]) + (
        " with changes not committed" if record["dirty"] else ""
    )
    # older results name the file
    again = record["command"].replace("python studies/", "python -m studies.").replace(".py", "")
    seeds = f"seeds {ranges(record['seeds'])}; " if record["seeds"] else ""
    blocks.append(
        f"`{again}`: {len(record['cases'])} cases, {seeds}{record['seconds']:,.0f} s of computing; "
        f"commit {commits}; configuration `{record['config_hash'][:12]}`; "
        + ", ".join(f"{k} {v}" for k, v in record["versions"].items())
        + f". All numbers: [studies/results/{record['name']}.json](../studies/results/{record['name']}.json)."
    )
    return "\n\n".join(blocks)


def ranges(numbers: list[int]) -> str:
    """Whole numbers with runs of neighbours drawn together: 1–5, 9."""
    out: list[list[int]] = []
    for x in sorted(numbers):
        if out and x == out[-1][1] + 1:
            out[-1][1] = x
        else:
            out.append([x, x])
    return ", ".join(str(a) if a == b else f"{a}–{b}" for a, b in out)


def _read(path: Path) -> dict[str, Any]:
    record = json.loads(path.read_text(encoding="utf-8"))
    lacking = [key for key in NEEDED if key not in record]
    if lacking and "claim" in record and record.get("complete", True):
        raise SystemExit(f"{path} lacks {', '.join(lacking)}: write it with studies/common/study.py")
    return record


def render(results: Path) -> str:
    """The whole page from a folder of results; incomplete and short ones, and what has no claim,
    are left out."""
    records = [_read(path) for path in sorted(results.glob("*.json"))
               if not path.name.endswith(".partial.json")]
    shown = [record for record in records if "claim" in record and record["complete"] and not record["short"]]
    if not shown:
        return HEAD + "\nNo study has been run yet.\n"
    rows = [
        [
            f"[{r['name']}](#{r['name'].replace(' ', '-')})",
            r["claim"],
            f"{sum(v['met'] for v in r['verdicts'])} of {len(r['verdicts'])}",
        ]
        for r in shown
    ]
    return ("\n\n".join([HEAD.rstrip(), table(["study", "claim", "goals met"], rows), *map(section, shown)])
            + "\n")


def main() -> int:
    """Write or check the page."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--check", action="store_true",
                        help="write nothing; exit with 1 where the page is stale")
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--page", type=Path, default=PAGE)
    asked = parser.parse_args()
    page = render(asked.results)
    if asked.check:
        if asked.page.is_file() and asked.page.read_text(encoding="utf-8") == page:
            return 0
        print(f"{asked.page} is not what {asked.results} says: run python tools/make_results.py",
              file=sys.stderr)
        return 1
    asked.page.parent.mkdir(parents=True, exist_ok=True)
    asked.page.write_text(page, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
