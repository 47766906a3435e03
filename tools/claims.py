"""The claims on the pages in docs/evidence/, each with the study line that supports it.

A claim is registered if its line belongs to a hypothesis in studies/registered/, a test if it is a promise of
the program, and otherwise exploratory: stated, or given a goal, after we saw the results.
"""

import tomllib
from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from cells import shown, table

CLAIMS = Path(__file__).parent.parent / "studies" / "claims.toml"
HEAD = ["kind", "training seeds × world seeds", "effect (95% interval)", "goal", "outcome"]
KEYS = ("id", "says", "study", "line", "of", "kind", "failed", "explained")


def read(path: Path = CLAIMS) -> list[dict[str, Any]]:
    """Return the claims. Raises a ValueError that names a claim's missing or unknown key."""
    claims: list[dict[str, Any]] = tomllib.loads(path.read_text(encoding="utf-8"))["claim"]
    for claim in claims:
        name = claim.get("id", claim)
        if odd := set(claim) - set(KEYS):
            raise ValueError(
                f"{path}: claim {name!r}: unknown key {sorted(odd)[0]!r}; expected {', '.join(KEYS)}"
            )
        if lacking := set(KEYS[:4]) - set(claim):
            raise ValueError(f"{path}: claim {name!r} lacks {', '.join(sorted(lacking))}")
    names = [claim["id"] for claim in claims]
    if twice := {name for name in names if names.count(name) > 1}:
        raise ValueError(f"{path}: duplicate claims: {', '.join(sorted(twice))}")
    return claims


def section(claim: Mapping[str, Any], record: Mapping[str, Any]) -> str:
    """Return a claim under a heading with the anchor claim-ID. Raises a ValueError if its line or cases are
    missing from the result."""
    line = line_of(claim, record)
    how = claim.get("kind", "registered" if "registered" in line else "exploratory")
    note = f" {claim['failed']}" if "failed" in claim and not line["met"] else ""
    row = [
        how,
        replicates(claim, record),
        shown(line["value"]),
        line["goal"] if "registered" in line else shown(line["goal"]),
        "passed" if line["met"] else "**failed**",
    ]
    link = f"\n\n[One run, explained](explained.md): {claim['explained']}." if "explained" in claim else ""
    return f"### Claim: {claim['id']}\n\n{claim['says']}{note}\n\n{table(HEAD, [row])}{link}"


def line_of(claim: Mapping[str, Any], record: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the verdict that supports a claim."""
    lines = {line["statement"]: line for line in record["verdicts"]}
    found = [line for statement, line in lines.items() if statement.startswith(claim["line"])]
    if len(found) != 1:
        near = get_close_matches(claim["line"], lines, 1, 0.3)
        raise ValueError(
            f"claim {claim['id']!r}: {len(found)} lines of {claim['study']} begin with "
            f"{claim['line']!r}" + (f"; did you mean {near[0]!r}?" if near else "")
        )
    return found[0]


def replicates(claim: Mapping[str, Any], record: Mapping[str, Any]) -> str:
    """Return the number of seeds of each kind in a claim's cases (or in the `lives` of their results) and the
    kind of replicate."""
    wanted = claim.get("of", {})
    cases = [
        life
        for entry in record["cases"]
        if all(
            entry["case"].get(key) in (value if isinstance(value, list) else [value])
            for key, value in wanted.items()
        )
        for life in entry.get("result", {}).get("lives", [entry["case"]])
    ]
    if not cases:
        raise ValueError(f"claim {claim['id']!r}: no case of {claim['study']} has {wanted}")
    training, worlds = ({case[key] for case in cases if key in case} for key in ("training", "seed"))
    seeds = f"{len(training) or 1} × {len(worlds) or 1}"
    return seeds if len(cases) == (len(training) or 1) * (len(worlds) or 1) else f"{seeds}, n = {len(cases)}"
