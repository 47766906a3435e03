"""The page of a sweep: sweep.html and its figures."""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from ecs_eco.analysis.page import drawn, interval, number, page, table, verdict, write_text
from ecs_eco.analysis.style import colors
from ecs_eco.analysis.survival import Interval
from ecs_eco.record.container import inside
from ecs_eco.record.seal import read_manifest
from ecs_eco.sweeps import figures, response
from ecs_eco.sweeps.folder import RUN, Sweep
from ecs_eco.sweeps.response import Outcome, Row, group, outcomes_of

PAGE = "sweep.html"
MOST_PANELS = 6  # outcomes of a figure
MOST_ROWS = 400  # of the table of points
_RESPONSE = (
    "Means at each value with 95 % intervals over seeds; dots are single runs. Where more than one "
    "value varies, each seed's mean over all others comes first."
)
_POINTS = "Each point of the hypercube: its mean with the 95 % interval over seeds."
_HEAT = "Means over seeds, and over what else varies; empty where no run has a number."


def write_page(sweep: Sweep, rows: Sequence[Row], failed: dict[int, str]) -> Path:
    """Write sweep.html and figures/ from the rows of the table; return the page."""
    folder = inside(sweep.folder, sweep.folder / "figures")
    species = list(sweep.content["config"]["species"])
    species = [name for name in species if f"{name}.mean" in rows[0]]
    hue = colors(species, read_manifest(sweep.job_folder(rows[0]["job"]) / RUN).get("colors"))
    outcomes, keys = outcomes_of(rows, species), list(sweep.jobs[0].values)
    blocks = [
        *_head(sweep, rows, failed),
        *_responses(rows, keys, outcomes, hue, folder),
        *_points(rows, keys, outcomes),
        *_origin(sweep, rows),
    ]
    title = sweep.content["title"] or sweep.content["world"]
    return write_text(sweep.folder / PAGE, page(f"Sweep: {title}", *blocks))


def lines_of(sweep: Sweep, rows: Sequence[Row]) -> tuple[str, ...]:
    """Return the result in words: in how many runs all persist, by treatment."""
    out = []
    for treatment, part in group(rows, lambda row: row["treatment"]).items():
        kept = sum(row["persisted"] for row in part)
        points = len({row["point"] for row in part})
        out.append(
            f"{treatment}: all species persist in {kept} of {len(part)} runs of {sweep.ticks:,} ticks"
            + (f", at {points} points" if points > 1 else "")
        )
    return tuple(out)


def _head(sweep: Sweep, rows: Sequence[Row], failed: dict[int, str]) -> list[str]:
    title = sweep.content["title"] or sweep.content["world"]
    lost = not all(row["persisted"] for row in rows)
    blocks = [
        f"<h1>Sweep: {escape(title)}</h1>",
        verdict(lines_of(sweep, rows), lost),
        "<p class='under'>Seeds are the replicates. Intervals are 95 %.</p>",
    ]
    if missing := len(sweep.jobs) - len(rows):
        why = f", {len(failed)} of them because they failed" if failed else ""
        blocks.append(f"<p class='under'>{missing} of {len(sweep.jobs)} jobs are not done{why}.</p>")
    return blocks


def _responses(
    rows: Sequence[Row], keys: list[str], outcomes: list[Outcome], hue: dict[str, str], folder: Path
) -> list[str]:
    """How outcomes respond to the values, as pictures."""
    outcomes = [outcome for outcome in outcomes if len({row[outcome.column] for row in rows}) > 1]
    if not keys or not outcomes:
        return []
    shown = figures.responses(rows, keys[:4], outcomes, hue)
    each = all(len({str(row[key]) for row in rows}) <= figures.FEW for key in keys)
    blocks = [
        "<h2>Response</h2>",
        drawn(shown, folder / "response.svg", _RESPONSE if each else f"{_RESPONSE} {_POINTS}"),
    ]
    for i, pair in enumerate(figures.pairs_of(rows, keys)):
        shown = figures.heat(rows, pair, outcomes[:MOST_PANELS])
        blocks += [
            f"<h2>{escape(figures.short(pair[0]))} and {escape(figures.short(pair[1]))}</h2>",
            drawn(shown, folder / f"heat-{i + 1}.svg", _HEAT),
        ]
    return blocks


def _points(rows: Sequence[Row], keys: list[str], outcomes: list[Outcome]) -> list[str]:
    """A table with a row for each point and treatment."""
    parts = list(group(rows, lambda row: (row["point"], row["treatment"])).values())
    treatments = len({row["treatment"] for row in rows}) > 1
    head = [
        *map(figures.short, keys),
        *(["treatment"] if treatments else []),
        "runs",
        *(outcome.label for outcome in outcomes),
    ]
    cells = [
        [
            *(part[0][key] for key in keys),
            *([part[0]["treatment"]] if treatments else []),
            len(part),
            *(_cell(response.interval(part, outcome)) for outcome in outcomes),
        ]
        for part in parts[:MOST_ROWS]
    ]
    blocks = ["<h2>All points</h2>", table(head, cells)]
    if len(parts) > MOST_ROWS:
        blocks.append(f"<p>… and {len(parts) - MOST_ROWS} more, in runs.parquet.</p>")
    return blocks


def _cell(x: Interval) -> str:
    return number(x.value) if x.low != x.low else interval(x)


def _origin(sweep: Sweep, rows: Sequence[Row]) -> list[str]:
    """Where the numbers come from."""
    commits = sorted({str(row["git_commit"])[:12] for row in rows})
    seeds: dict[str, Any] = {kind: sweep.content["plan"][f"{kind}_seeds"] for kind in ("world", "training")}
    words = "; ".join(f"{kind} seeds {', '.join(map(str, own))}" for kind, own in seeds.items() if own)
    hours = sum(row["seconds"] for row in rows) / 3600
    return [
        "<h2>How it was made</h2>",
        f"<p>Plan {escape(sweep.content['source'])} ({sweep.hash[:16]}), {escape(words)}; "
        f"commit {escape(', '.join(commits))}; {number(hours)} hours of one core, "
        f"machines: {len({row['host'] for row in rows})}. Each run has its folder in jobs/; every run is a "
        "row of runs.parquet.</p>",
    ]
