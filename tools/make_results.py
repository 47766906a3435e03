"""Write docs/results.md from studies/results/*.json: each claim, what was measured,
and how to measure it again.

python tools/make_results.py            writes the file
python tools/make_results.py --check    fails where the file is not what the results say
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
from pathlib import Path
from typing import Any

from claims import HEAD as CLAIMS_HEAD  # the files beside this one
from claims import read as read_claims
from claims import rows as rows_of_claims
from persistence import opening

ROOT = Path(__file__).parent.parent
RESULTS = ROOT / "studies" / "results"
PAGE = ROOT / "docs" / "results.md"
NEEDED: tuple[str, ...] = (
    "name",
    "claim",
    "complete",
    "short",
    "command",
    "verdicts",
    "cases",
    "seeds",
    "seconds",
)
NEEDED += ("commits", "dirty", "config_hash", "versions")
HEAD = """# Results

<!-- Written by tools/make_results.py from studies/results/*.json: change those, not this page. -->

What is claimed, and what it rests on. *Registered*: hypotheses, arms, seeds, statistic and margins were \
committed before the first run
(`studies/registered/`). *Explored*: seen first, or with a goal that was set or changed after a look; world \
and settings may have been chosen
on the way. Where nothing else is said policies are those that come with a world: one training seed.
"""
STUDIES = """## All studies

Each has one script that tests its claim. Seeds are the replicates; a goal that was not met stays here. \
What is told of worlds opens
with the share of runs in which all persisted, an arm in which they were meant to die out included. Lines \
without a goal are reported, and not
counted as met."""

STALE = "**The world or the study has changed since: to be run again.**"
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
        return (
            f"{text(x[0])} ({text(x[1])} … {text(x[2])})"
            if len(x) == 3 and numbers
            else ", ".join(map(text, x))
        )
    return str(x).replace("|", "\\|").replace("\n", " ")


def table(head: list[str], rows: list[list[Any]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(text(x) for x in line) + " |" for line in lines)


def counted(record: dict[str, Any]) -> str:
    """How many goals were met, of those that there were."""
    goals = [line for line in record["verdicts"] if not is_reported(line)]
    return f"{sum(line['met'] for line in goals)} of {len(goals)}"


def said(line: dict[str, Any]) -> str:
    """What became of a line, for the first column."""
    word = "reported" if is_reported(line) else "met" if line["met"] else "**not met**"
    return f"{word}, registered" if "registered" in line else word


def stale(name: str, record: dict[str, Any]) -> bool:
    """Whether a result is of another configuration than its study has today."""
    study = study_of(name)
    return study is not None and bool(study.whole_config_hash() != record["config_hash"])


def claim_of(record: dict[str, Any]) -> str:
    """What a study claims today."""
    study = study_of(record["name"])
    return str(record["claim"] if study is None else study.claim)


def study_of(name: str) -> Any:
    """The study of a result, as its script has it today; None where it is none of studies/."""
    return _module(name).STUDY if (ROOT / "studies" / f"{name}.py").is_file() else None


def is_reported(line: dict[str, Any]) -> bool:
    """Whether a line has no goal."""
    return bool(_module("common.study").is_reported(line))


def _module(name: str) -> Any:
    if str(ROOT) not in sys.path:  # run as a script
        sys.path.insert(0, str(ROOT))
    return importlib.import_module(f"studies.{name}")


def section(record: dict[str, Any]) -> str:
    """One study: claim, verdicts, table and where they come from."""
    rows = [[said(line), line["statement"], line["value"], line["goal"]] for line in record["verdicts"]]
    blocks = [
        f"## {record['name']}",
        claim_of(record),
        *([f"**{summary}**"] if (summary := opening(record)) else []),
        f"{counted(record)} goals met.",
        *([STALE] if stale(record["name"], record) else []),
        table(["", "statement", "measured", "goal"], rows),
    ]
    if record.get("table"):
        blocks.append(table(record["table"]["head"], record["table"]["rows"]))
    if record.get("notes"):
        blocks.append(record["notes"])
    if "registration" in record:
        noted = record["registration"]
        blocks.append(
            f"Registered in [{noted['file']}](../{noted['file']}), sha256 "
            f"`{noted['sha256'][:12]}`, commit `{noted['commit'][:12]}`."
        )
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
    records = [
        _read(path) for path in sorted(results.glob("*.json")) if not path.name.endswith(".partial.json")
    ]
    shown = [record for record in records if "claim" in record and record["complete"] and not record["short"]]
    if not shown:
        return HEAD + "\nNo study has been run yet.\n"
    rows = [[f"[{r['name']}](#{r['name']})", claim_of(r), counted(r)] for r in shown]
    known = {r["name"]: r for r in shown}
    claims = [claim for claim in read_claims() if results == RESULTS or claim["study"] in known]
    return (
        "\n\n".join(
            [
                HEAD.rstrip(),
                table(CLAIMS_HEAD, rows_of_claims(known, claims)),
                STUDIES,
                table(["study", "claim", "goals met"], rows),
                *map(section, shown),
            ]
        )
        + "\n"
    )


def main() -> int:
    """Write or check the page."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit with 1 where the page is stale"
    )
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--page", type=Path, default=PAGE)
    asked = parser.parse_args()
    page = render(asked.results)
    if asked.check:
        if asked.page.is_file() and asked.page.read_text(encoding="utf-8") == page:
            return 0
        print(
            f"{asked.page} is not what {asked.results} says: run python tools/make_results.py",
            file=sys.stderr,
        )
        return 1
    asked.page.parent.mkdir(parents=True, exist_ok=True)
    asked.page.write_text(page, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
