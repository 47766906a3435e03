"""Write docs/benchmarks.md and the tables of README and docs/explanation/speed.md from benchmarks/results;
--check: only compare.

python tools/make_tables.py [--check]
"""

import argparse
import json
import sys
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
BENCHMARKS = ROOT / "benchmarks"
PAGE, README = ROOT / "docs" / "benchmarks.md", ROOT / "README.md"
SPEED = ROOT / "docs" / "explanation" / "speed.md"
MARKS = ("<!-- table: benchmarks -->", "<!-- end of table -->")
ORDER = (
    "animals",
    "animals_threads",
    "animals_pairs",
    "animals_pairs_million",
    "animals_pairs_threads",
    "animals_pairs_busy",
    "breakdown",
    "main_job",
    "main_job_training",
    "main_job_calls",
    "ablations",
    "animals_learning",
    "peers",
    "plants",
    "memory",
    "startup",
    "checkpoints",
    "checkpoints_cost",
    "bands",
    "bands_halo",
    "bands_model",
    "portable",
    "sweep_overhead",
    "sweep_overhead_ray",
    "firm_ground",
    "doors",
    "ppo",
    "individual_ppo",
    "births",
    "variable_births",
    "genomes",
    "viewer_cost",
    "viewer_frames",
    "page",
    "page_memory",
    "viewer_rewind",
    "viewer_stall",
    "wolf_sheep",
    "wolf_sheep_same",
    "wolf_sheep_profile",
    "kernel_arguments",
)
HEAD = """# How fast it is

Written by `tools/make_tables.py` from `benchmarks/results/`. The machines are shared and noisy: a ratio \
from one run
can be trusted, a figure alone drifts by half. `load` is that of the machine when a benchmark ended, \
on all its cores: with
more processes than cores every figure suffers.
"""


def read() -> dict[str, dict[str, Any]]:
    """Return all results that answer a question by name, in the order of the page."""
    results = {p.stem: json.loads(p.read_text()) for p in (BENCHMARKS / "results").glob("*.json")}
    shown = [name for name, result in results.items() if "question" in result]
    return {
        name: results[name] for name in sorted(shown, key=lambda n: (ORDER.index(n) if n in ORDER else 99, n))
    }


def show(value: Any) -> str:
    """Return a value as a cell."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}"
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
    return str(value)


def table(rows: list[dict[str, Any]]) -> str:
    """Return rows as a Markdown table."""
    head = list(rows[0])
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(show(r.get(h, "")) for h in head) + " |" for r in rows)])


def script(name: str) -> str:
    """Return the script that wrote a result: the longest that its name begins with."""
    return max((p.stem for p in BENCHMARKS.glob("*.py") if name.startswith(p.stem)), key=len)


def number_of(goal: dict[str, Any], result: dict[str, Any], where: str, column: str) -> float | None:
    """Return a number that a goal is about: of the row `where`, in its column; None where there is none."""
    if "item" in goal:
        return float(result[goal["item"]]["s"][{"row_before": "before", "row": "after"}[where]])
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
    """Return the table of what was aimed at, and what came of it."""
    rows = []
    for goal in tomllib.loads((BENCHMARKS / "goals.toml").read_text())["goal"]:
        path = folder / f"{goal['result']}.json"
        if not path.is_file():
            continue
        result = json.loads(path.read_text())
        now = number_of(goal, result, "row", "now")
        if "before" in goal:
            before = number_of(goal, result, "row", "before")
        else:
            before = number_of(goal, result, "row_before", "now")
        assert now is not None
        gain = None if before is None else now / before
        if "ratio" in goal:
            shorter = number_of({**goal, "per": ""}, result, "row", "ratio")
            assert shorter is not None
            gain = 1 / shorter
        rows.append(goal_row(goal, before, now, gain) | {"result": goal["result"]})
    return table(rows)


def goal_row(goal: dict[str, Any], before: float | None, now: float, gain: float | None) -> dict[str, Any]:
    """Return what the table says of a goal: the figure beside its aim, the gain beside that aimed at."""
    sign, aim = ("≥", goal["least"]) if "least" in goal else ("≤", goal["most"])

    def reached(value: float, wanted: float) -> bool:
        return value >= wanted if sign == "≥" else value <= wanted

    met, asked = reached(now, aim), aim / goal["was"] if "was" in goal else None
    known = asked is not None and gain is not None
    return {
        "work": goal["work"],
        "aim": f"{sign} {aim:,} {goal['unit']}",
        "before": "–" if before is None else before,
        "now": now,
        "met": met,
        "aim / figure when it was set": "–" if asked is None else f"{sign} {show(asked)}",
        "now / before": "–" if gain is None else gain,
        "met as a ratio": reached(gain, asked) if known else "–",
        "what is left": "" if met else goal.get("why", ""),
    }


GOALS = """## What was aimed at

From `benchmarks/goals.toml`. Before and now are from the same run on the same machine. Aims were set by \
figures of another one, so each is also held against the gain that it asked for: the aim by the figure when \
it was set, of a range the end that is farther from the aim. The machine is named below with each table, and \
its load: other work on it makes all of them longer, the first start, which takes both cores, up to three \
times; where two commits took turns, now / before is the median of turns. \
What was tried and dropped stands below the tables.
"""


def page(results: dict[str, dict[str, Any]]) -> str:
    """Return the page with every result."""
    parts = [HEAD, f"{GOALS}\n{goals(BENCHMARKS / 'results')}\n"]
    parts += [f"## {result['question']}\n\n{measured(name, result)}\n" for name, result in results.items()]
    return "\n".join(parts)


def measured(name: str, result: dict[str, Any]) -> str:
    """Return what a result says: the command, the table, its figure, notes, and the machine."""
    m = result["machine"]
    where = (
        f"{m['processor']}, {m['cores']} cores, load {m['load']}; "
        f"commit {(m['commit'] or 'unknown')[:12]}; "
        + ", ".join(f"{k} {v}" for k, v in m["versions"].items())
    )
    drawn = PAGE.parent / "img" / f"{name}.svg"
    shown = f"\n![{result['question']}](img/{drawn.name})\n" if drawn.is_file() else ""
    notes = "".join(f"\n- {k}: {show(v)}" for k, v in result["notes"].items())
    return f"`python benchmarks/{script(name)}.py` ({name})\n\n{table(result['rows'])}\n{shown}{notes}\n\n{where}."


def within(path: Path, text: str) -> str:
    """Return the content of a page with this text between its marks."""
    content = path.read_text()
    begin, end = content.index(MARKS[0]) + len(MARKS[0]), content.index(MARKS[1])
    return f"{content[:begin]}\n{text}\n{content[end:]}"


def summary(results: dict[str, dict[str, Any]]) -> str:
    """Return the README's table: one line a question, with the figures that answer it."""
    lines = ["| what | measured |", "|---|---|"]
    for name, pattern in (
        (
            "animals",
            "{animals:,} animals that sense, think and act, one core: "
            "{M organism-steps/s:.2f} M organism-steps/s",
        ),
        (
            "animals_threads",
            "{animals:,} animals, {threads} threads: {M organism-steps/s:.2f} M organism-steps/s",
        ),
        (
            "animals_learning",
            "{animals:,} animals that also learn by PPO, one core: {M organism-steps/s:.2f} M organism-steps/s",
        ),
        ("plants", "{plants:,} plants that grow and spread: {M plant-steps/s:.0f} M plant-steps/s"),
    ):
        if name in results:
            said = [pattern.format(**row).replace(" 1 threads", " 1 thread") for row in results[name]["rows"]]
            what, figures = zip(*(line.split(": ") for line in said), strict=True)
            lines += [f"| {w} | {f} |" for w, f in zip(what, figures, strict=True)]
    return "\n".join(
        [*lines, "", "All tables, with machine, load and versions: [docs/benchmarks.md](docs/benchmarks.md)."]
    )


def main() -> int:
    """Write or compare the pages."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--check", action="store_true")
    results = read()
    wanted = {
        PAGE: page(results),
        README: within(README, summary(results)),
        SPEED: within(SPEED, measured("ablations", results["ablations"])),
    }
    if parser.parse_args().check:
        stale = [path.name for path, text in wanted.items() if not path.is_file() or path.read_text() != text]
        if stale:
            print(
                f"{', '.join(stale)}: not what benchmarks/results says; run python tools/make_tables.py",
                file=sys.stderr,
            )
        return bool(stale)
    for path, text in wanted.items():
        path.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
