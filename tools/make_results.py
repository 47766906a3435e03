"""Write docs/evidence/ from studies/results/*.json: index.md from tools/evidence.md, a page for each study,
and docs/results.md, which redirects to these pages.

    python tools/make_results.py            writes the pages
    python tools/make_results.py --check    fails if a page is out of date
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from claims import read as read_claims  # files in this folder
from fields import written
from study_pages import NOTICE, RESULTS, command, counted, figure, page

ROOT = Path(__file__).parents[1]
TEMPLATE, DOCS = Path(__file__).with_name("evidence.md"), ROOT / "docs"
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
EXPLORED = "*Exploratory*."
FORWARD = """---
orphan: true
---

# Results

The results are in [Evidence](evidence/index.md), with a page for each study. Old links to claims on this
page still work."""


def read(results: Path) -> dict[str, dict[str, Any]]:
    """Return results by study name, excluding incomplete and short results and files without a claim."""
    paths = [path for path in sorted(results.glob("*.json")) if not path.name.endswith(".partial.json")]
    records = [_read(path) for path in paths]
    return {r["name"]: r for r in records if "claim" in r and r["complete"] and not r["short"]}


def _read(path: Path) -> dict[str, Any]:
    record: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    lacking = [key for key in NEEDED if key not in record]
    if lacking and "claim" in record and record.get("complete", True):
        raise SystemExit(f"{path} lacks {', '.join(lacking)}: write it with studies/common/study.py")
    return record


def pages(records: dict[str, dict[str, Any]], template: str) -> dict[str, str]:
    """Return the pages' text by path in docs/."""
    claims = [claim for claim in read_claims() if claim["study"] in records]
    written_pages = {f"evidence/{name}.md": page(record, claims) for name, record in records.items()}
    written_pages["evidence/index.md"] = index(records, template)
    written_pages["results.md"] = forward(records, claims)
    return written_pages


def index(records: dict[str, dict[str, Any]], template: str) -> str:
    """Return the index: the filled template and the list of all studies."""

    def own(place: str) -> str | None:
        kind, _, names = place.partition(":")
        if kind == "figure":
            return figure(names.strip(), "../img")
        if kind == "origin":
            return origin([records[name.strip()] for name in names.split(",")])
        return listed(records) if place == "studies" else None

    toctree = "```{toctree}\n:hidden:\n:glob:\n\n*\n```"
    return f"{written(template, own).rstrip()}\n\n{toctree}\n"


def origin(records: list[dict[str, Any]]) -> str:
    """Return a finding's last lines: whether it is registered or exploratory, the goals passed with links,
    and the command to repeat it."""
    noted = [r["registration"]["file"] for r in records if "registration" in r]
    seen = (
        "*Registered*: " + " and ".join(f"[{Path(file).name}](../../{file})" for file in noted) + "."
        if len(noted) == len(records)
        else EXPLORED
    )
    return (
        f"{seen}\nGoals passed: {listed({r['name']: r for r in records})}.\nRun again: "
        + ", ".join(f"`{command(r)}`" for r in records)
        + "."
    )


def listed(records: dict[str, dict[str, Any]]) -> str:
    """Return the list of all studies with the numbers of goals passed and set."""
    return ", ".join(f"[{name}]({name}.md) {counted(r).replace(' of ', '/')}" for name, r in records.items())


def forward(records: dict[str, dict[str, Any]], claims: list[dict[str, Any]]) -> str:
    """Return the page that keeps old links working, with an anchor for each study and claim."""
    lines = [FORWARD, "", NOTICE, ""]
    for name in records:
        lines += [f"## {name}", "", f"[The page of this study](evidence/{name}.md)", ""]
        own = [claim["id"] for claim in claims if claim["study"] == name]
        links = [f'<a id="claim-{key}"></a>[{key}](evidence/{name}.md#claim-{key})' for key in own]
        lines += [f"Claims: {', '.join(links)}.", ""] if own else []
    return "\n".join(lines).rstrip() + "\n"


def main() -> int:
    """Write or check the pages."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit with 1 if a page is out of date"
    )
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--docs", type=Path, default=DOCS)
    parser.add_argument("--template", type=Path, default=TEMPLATE, help="template of evidence/index.md")
    asked = parser.parse_args()
    wanted = pages(read(asked.results), asked.template.read_text(encoding="utf-8"))
    there = {f"evidence/{path.name}" for path in (asked.docs / "evidence").glob("*.md")}
    if asked.check:
        stale = [p for p, text in wanted.items() if not _same(asked.docs / p, text)] + sorted(
            there - set(wanted)
        )
        if stale:
            print(
                f"{', '.join(stale)}: differs from {asked.results}; run python tools/make_results.py",
                file=sys.stderr,
            )
        return bool(stale)
    for place in there - set(wanted):
        (asked.docs / place).unlink()
    (asked.docs / "evidence").mkdir(parents=True, exist_ok=True)
    for place, text in wanted.items():
        (asked.docs / place).write_text(text, encoding="utf-8")
    return 0


def _same(path: Path, text: str) -> bool:
    return path.is_file() and path.read_text(encoding="utf-8") == text


if __name__ == "__main__":
    sys.exit(main())
