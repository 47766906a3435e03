"""The table of goals in benchmarks/goals.toml, with the measured values."""

import json
import tomllib
from pathlib import Path
from typing import Any

from cells import typeset
from fields import show

GOALS = Path(__file__).parents[1] / "benchmarks" / "goals.toml"


def goal_number(goal: dict[str, Any], result: dict[str, Any], where: str, column: str) -> float | None:
    """Return a goal's number, from its column in the row `where` or from a note, or None."""
    if "item" in goal:
        return float(result[goal["item"]]["s"][{"row_before": "before", "row": "after"}[where]])
    if "note" in goal:
        return 100 * float(result["notes"][goal["note"]]) if where == "row" else None
    if column not in goal or (where not in goal and where != "row"):
        return None
    wanted = goal.get(where, {})
    row = next(r for r in result["rows"] if wanted.items() <= r.items())
    value = float(row[goal[column]])
    per = goal.get("per")
    return {"steps": 1e3 / value, "ticks": 1e9 / (value * row.get("animals", 1)), "times": 1 / value}.get(
        per or "", value
    )


def goals(folder: Path) -> str:
    """Return the table of goals and measured values."""
    rows = []
    for goal in tomllib.loads(GOALS.read_text(encoding="utf-8"))["goal"]:
        path = folder / f"{goal['result']}.json"
        if not path.is_file():
            continue
        result = json.loads(path.read_text())
        now = goal_number(goal, result, "row", "now")
        if "before" in goal:
            before = goal_number(goal, result, "row", "before")
        else:
            before = goal_number(goal, result, "row_before", "now")
        assert now is not None
        gain = None if before is None else now / before
        if "ratio" in goal:
            shorter = goal_number({**goal, "per": ""}, result, "row", "ratio")
            assert shorter is not None
            gain = 1 / shorter
        rows.append(goal_row(goal, before, now, gain) | {"result": goal["result"]})
    head = list(rows[0])
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(typeset(show(r[h])) for h in head) + " |" for r in rows)])


def goal_row(goal: dict[str, Any], before: float | None, now: float, gain: float | None) -> dict[str, Any]:
    """Return a goal's row: the time against the goal, and the gain against the required gain."""
    sign, aim = ("≥", goal["least"]) if "least" in goal else ("≤", goal["most"])

    def reached(value: float, wanted: float) -> bool:
        return value >= wanted if sign == "≥" else value <= wanted

    met, asked = reached(now, aim), aim / goal["was"] if "was" in goal else None
    known = asked is not None and gain is not None
    return {
        "work": goal["work"],
        "goal": f"{sign} {aim:,} {goal['unit']}",
        "before": "–" if before is None else before,
        "now": now,
        "passed": met,
        "goal / when set": "–" if asked is None else f"{sign} {show(asked)}",
        "now / before": "–" if gain is None else gain,
        "gain passed": reached(gain, asked) if known else "–",
        "what remains": "" if met else goal.get("why", ""),
    }
