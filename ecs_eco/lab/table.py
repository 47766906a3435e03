"""The results of a sweep: a table with a row for each finished run, figures and a page."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from ecs_eco.analysis.measures import WORLD
from ecs_eco.analysis.page import drawn, interval, number, page, table, verdict, write_text
from ecs_eco.analysis.replicates import Effect, seeds_section
from ecs_eco.analysis.style import colors
from ecs_eco.analysis.survival import Interval
from ecs_eco.config import WorldConfig
from ecs_eco.engine.errors import RecordingError, listed, nearest, refusal
from ecs_eco.lab import response
from ecs_eco.lab.executors import built
from ecs_eco.lab.folder import RUN, Sweep
from ecs_eco.lab.jobs import read_done
from ecs_eco.lab.plan import Sample
from ecs_eco.lab.response import Outcome, Row, outcomes_of, turnover_of
from ecs_eco.lab.sweep import Survey
from ecs_eco.lab.treatments import UNTREATED
from ecs_eco.lab.work import group
from ecs_eco.record.parquet import write_part
from ecs_eco.record.seal import read_manifest

RUNS = "runs.parquet"
FEWEST = 3  # seeds before an interval counts


@dataclass(frozen=True)
class Collected:
    """The files that `collect` wrote."""

    table: Path
    page: Path
    missing: int  # number of unfinished jobs
    lines: tuple[str, ...]  # summary sentences


def collect(sweep: Sweep) -> Collected:
    """Write runs.parquet, sweep.html and figures/ from all finished jobs.

    Parameters
    ----------
    sweep : Sweep
        A sweep from `read_sweep`.

    Returns
    -------
    Collected
        The files, the number of unfinished jobs, and a summary.

    Raises
    ------
    RecordingError
        If no job is finished.

    Examples
    --------
    >>> from ecs_eco.lab import run_sweep
    >>> plan = {"world": "predator-prey", "ticks": 10, "grid": {"species.deer.metabolism.basal": [0.004]}}
    >>> outcome = run_sweep(plan, "swept", workers=1)
    >>> from ecs_eco.lab.folder import read_sweep
    >>> from ecs_eco.lab.table import collect
    >>> collect(read_sweep("swept")).table.name
    'runs.parquet'
    """
    rows = rows_of(sweep)
    if not rows:
        raise RecordingError(f"{sweep.folder}: no job is done yet; run: ecs-eco sweep resume {sweep.folder}")
    return Collected(
        write_table(rows, sweep.folder / RUNS),
        write_page(sweep, rows, Survey(sweep).look().failed),
        len(sweep.jobs) - len(rows),
        lines_of(sweep, rows),
    )


def rows_of(sweep: Sweep) -> list[dict[str, Any]]:
    """Return a row for each finished job, in order; all rows have the same keys."""
    rows = [
        row_of(job.point, done) for job in sweep.jobs if (done := read_done(sweep, job.number)) is not None
    ]
    columns = sorted({name for row in rows for name in row}, key=_place(rows))
    return [{name: row.get(name, 0.0 if ".died." in name else None) for name in columns} for row in rows]


def missing_for(sweep: Sweep, column: str, width: float) -> list[int]:
    """Return the jobs of the next seeds at each point and treatment at which the 95% interval of the mean of a
    column is wider than `width`: at least three seeds, then half as many again. Raises ConfigError if
    no run has such a column."""
    check_response(column, sweep.base)
    jobs = group(sweep.jobs, lambda job: (job.point, job.treatment))
    done = {row["job"]: {column: 0.0} | row for row in rows_of(sweep)}  # without deaths, there is no column
    out: list[tuple[int, int]] = []
    for own in jobs.values():
        rows = [done[job.number] for job in own if job.number in done]
        mean = response.interval(rows, Outcome(column, column, share=column == "persisted")) if rows else None
        if mean is None or not mean.high - mean.low <= width or len(rows) < FEWEST:
            left = sorted((job.world_seed, job.number) for job in own if job.number not in done)
            out += left[: max(FEWEST - len(rows), len(rows) // 2, 1)]
    return [number for _, number in sorted(out)]


def check_response(column: str, world: WorldConfig) -> None:
    """Raise ConfigError if runs of a world have no such column of results."""
    known = [
        "persisted",
        "lived",
        *(f"{name}.{what}" for name in world.species for what in ("mean", "final", "births")),
    ]
    kinds = ("", *(f".{name}" for name in world.species))
    known += [f"{name}{of}.mean" for name in world.reporters for of in kinds]
    if ".died." in column:
        culls = {str(one.cause) for one in world.interventions if hasattr(one, "cause")}
        causes = sorted(culls.union(built(world).causes))
        known += [f"{name}.died.{cause}" for name in world.species for cause in causes]
    if column not in known:
        raise refusal((), "no such response", column, listed(known), nearest(column, known), "--response")


def row_of(point: int, done: dict[str, Any]) -> dict[str, Any]:
    """Return the row of a finished job: its identity, values and results, with times in ticks. "deer.mean" is
    the mean number over the run, "deer.final" the last one, `ended_by` and `ended_at` the condition that
    ended the run and its tick; "deer.period" is given for cycles, and "deer.died.starved" counts deaths."""
    summary = done["summary"]
    row = {
        "job": done["number"],
        "point": point,
        **done["values"],
        "treatment": done["treatment"] or UNTREATED,
        "training_seed": done["training_seed"],
        "world_seed": done["world_seed"],
        "ticks": done["ticks"],
        "persisted": summary["persisted"],
        "lived": summary["lived"],
        "ended_by": (ended := done.get("ended_by") or {}).get("by"),
        "ended_at": ended.get("tick"),
    }
    for name, numbers in summary["species"].items():
        row |= {f"{name}.{key}": value for key, value in numbers.items() if key != "deaths"}
        row |= {f"{name}.died.{cause}": n for cause, n in numbers["deaths"].items()}
    for name, kinds in summary["reporters"].items():
        for of, numbers in kinds.items():
            of = "" if of == WORLD else f".{of}"
            row |= {f"{name}{of}.{key}": value for key, value in numbers.items()}
    return row | {
        "seconds": done["seconds"],
        "host": done["host"],
        "git_commit": done["git_commit"],
        "config_hash": done["config_hash"],
        "digest": done["digest"],
    }


def _place(rows: list[dict[str, Any]]) -> Any:
    """Return a sort key that keeps columns in the same order as in the rows."""
    places: dict[str, tuple[int, str]] = {}
    for row in rows:
        at = 0
        for name in row:
            at = places[name][0] if name in places else at + 1
            places.setdefault(name, (at, name))
    return lambda name: places[name]


def write_table(rows: list[dict[str, Any]], path: Path) -> Path:
    """Write rows as a Parquet file; columns with values of different types become text."""
    import pyarrow as pa

    columns = {}
    for name in rows[0]:
        values = [row[name] for row in rows]
        if len({type(v) for v in values if v is not None} - {int, float}) > 1 or any(
            isinstance(v, list | dict) for v in values
        ):
            values = [str(v) for v in values]
        elif any(isinstance(v, float) for v in values):
            values = [None if v is None else float(v) for v in values]
        columns[name] = values
    write_part(pa.table(columns), path)
    return path


PAGE = "sweep.html"
MOST_PANELS = 6  # maximum number of outcomes per figure
MOST_ROWS = 400  # maximum length of the table of points
_RESPONSE = (
    "Means at each value with 95% intervals over seeds; dots are single runs. If several values vary, each "
    "seed's mean over the other values is computed first."
)
_POINTS = "For drawn points, each point is shown: its mean with the 95% interval over seeds."
_TURNOVER = f"Numbers per run; at most {MOST_PANELS} panels. runs.parquet contains all births and deaths."
_HEAT = "Means over seeds and all other varied values; cells are empty if no run has a value."

_INDICES = "Means over seeds, with 95% intervals over points. Variance between seeds counts as interaction."


def write_page(sweep: Sweep, rows: Sequence[Row], failed: dict[int, str]) -> Path:
    """Write sweep.html and figures/ from the rows of the table; return the path of the page."""
    folder = sweep.folder / "figures"
    species = list(sweep.content["config"]["species"])
    species = [name for name in species if f"{name}.mean" in rows[0]]
    hue = colors(species, read_manifest(sweep.job_folder(rows[0]["job"]) / RUN).get("colors"))
    outcomes, keys = outcomes_of(rows, species), list(sweep.jobs[0].values)
    given = sweep.content["plan"].get("latin_hypercube") or {}
    design = given.get("design", "lhs")
    found = [] if design == "lhs" else [*response.indices_of(Sample.model_validate(given), rows, outcomes)]
    blocks = [
        *_head(sweep, rows, failed, [*_opening(rows, keys, outcomes), *_depends(design, found)]),
        *_responses(rows, keys, outcomes, turnover_of(rows, species), hue, folder),
        *_sensitivity(sweep, design, found, folder),
        *_points(rows, keys, outcomes),
        *_seeds(rows, keys, outcomes),
        *_origin(sweep, rows),
    ]
    title = sweep.content["title"] or sweep.content["world"]
    return write_text(sweep.folder / PAGE, page(f"Sweep: {title}", *blocks))


def lines_of(sweep: Sweep, rows: Sequence[Row]) -> tuple[str, ...]:
    """Return, for each treatment, a sentence with the number of runs in which all species persist."""
    out = []
    for treatment, part in group(rows, lambda row: row["treatment"]).items():
        kept = sum(row["persisted"] for row in part)
        points = len({row["point"] for row in part})
        ended = sum(row["ended_by"] is not None for row in part)
        out.append(
            f"{treatment}: all species persist in {kept} of {len(part)} runs of {sweep.ticks:,} ticks"
            + (f", at {points} points" if points > 1 else "")
            + (f"; {ended} ended earlier by a condition" if ended else "")
        )
    return tuple(out)


def _opening(rows: Sequence[Row], keys: list[str], outcomes: list[Outcome]) -> list[str]:
    """Return a sentence on the largest clear difference between the ends of a key's values, in larger means."""
    kept = [row for row in rows if row["treatment"] == UNTREATED] or rows
    tried, found = 0, []
    for key in keys:
        ends = response.values_of(kept, key)
        if not 2 <= len(ends) <= response.FEW or not all(isinstance(end, int | float) for end in ends):
            continue
        for outcome in outcomes:
            low, high = (
                response.of_seeds([row for row in kept if row[key] == end], outcome.column)
                for end in (ends[0], ends[-1])
            )
            if min(len(low), len(high)) < FEWEST:
                continue
            tried += 1
            x = Effect("", high, low, outcome.share).after(max(len(low), len(high)))
            if x.low > 0 or x.high < 0:
                words = f"{key} = {ends[-1]} instead of {ends[0]}: {outcome.label} {'+' * (x.value > 0)}"
                found.append((abs(x.value) / max(abs(low.mean()), abs(high.mean())), words + interval(x)))
    if not tried:
        return []
    if not found:
        return ["No outcome differs clearly between the lowest and the highest value of a key."]
    return [f"{max(found)[1]}, the largest of {tried} differences relative to the mean."]


def _depends(design: str, found: Sequence[tuple[str, Outcome, response.Indices]]) -> list[str]:
    """Return a sentence on the key with the largest total index or, for Morris, the largest μ*."""
    best = design == "sobol"
    ranked = [
        (of[key][best].value, f"{what.label} depends", key, of) for _, what, of in found[:1] for key in of
    ]
    return [
        f"The {words} most on {key} ({response.INDEX_NAMES[design][best]} {_cell(of[key][best])})."
        for _, words, key, of in sorted(ranked, key=lambda one: -one[0])[:1]
    ]


def _head(sweep: Sweep, rows: Sequence[Row], failed: dict[int, str], opening: Sequence[str]) -> list[str]:
    title = sweep.content["title"] or sweep.content["world"]
    lost = not all(row["persisted"] for row in rows)
    blocks = [
        f"<h1>Sweep: {escape(title)}</h1>",
        verdict([*(f"{line}." for line in lines_of(sweep, rows)), *opening], lost),
        "<p class='under'>The replicates are seeds. All intervals are 95% intervals.</p>",
    ]
    if missing := len(sweep.jobs) - len(rows):
        why = f", {len(failed)} of them because they failed" if failed else ""
        blocks.append(f"<p class='under'>{missing} of {len(sweep.jobs)} jobs are not done{why}.</p>")
    return blocks


def _responses(
    rows: Sequence[Row],
    keys: list[str],
    outcomes: list[Outcome],
    turnover: list[Outcome],
    hue: dict[str, str],
    folder: Path,
) -> list[str]:
    """Return the sections on responses, and on births and deaths by cause, the most frequent first."""
    blocks: list[str] = []
    outcomes, turnover = (
        [outcome for outcome in some if keys and len({row[outcome.column] for row in rows}) > 1]
        for some in (outcomes, turnover)
    )
    if outcomes:
        shown = response.responses(rows, keys[:4], outcomes, hue)
        each = all(len({str(row[key]) for row in rows}) <= response.FEW for key in keys)
        blocks += [
            "<h2>Response</h2>",
            drawn(shown, folder / "response.svg", _RESPONSE if each else f"{_RESPONSE} {_POINTS}"),
        ]
        for i, pair in enumerate(response.pairs_of(rows, keys)):
            shown = response.heat(rows, pair, outcomes[:MOST_PANELS])
            blocks += [
                f"<h2>{escape(response.short(pair[0]))} and {escape(response.short(pair[1]))}</h2>",
                drawn(shown, folder / f"heat-{i + 1}.svg", _HEAT),
            ]
    if turnover:
        turnover.sort(key=lambda what: -sum(row[what.column] or 0 for row in rows))
        shown = response.responses(rows, keys[:4], turnover[:MOST_PANELS], hue)
        blocks += ["<h2>Births and deaths</h2>", drawn(shown, folder / "turnover.svg", _TURNOVER)]
    return blocks


def _sensitivity(
    sweep: Sweep, design: str, found: Sequence[tuple[str, Outcome, response.Indices]], folder: Path
) -> list[str]:
    """Return the section with the indices of complete Sobol or Morris designs; write sensitivity.parquet."""
    if design == "lhs":
        return []
    if not found:
        return ["<h2>Sensitivity</h2><p>Indices need all points, at which an outcome differs.</p>"]
    rows = [
        {"treatment": treatment, "outcome": outcome.column, "key": key, "index": name, **x._asdict()}
        for treatment, outcome, own in found
        for key, both in own.items()
        for name, x in zip(response.INDEX_NAMES[design], both, strict=True)
    ]
    write_table(rows, sweep.folder / "sensitivity.parquet")
    cells = [
        [treatment, outcome.label, response.short(key), *map(_cell, both)]
        for treatment, outcome, own in found
        for key, both in own.items()
    ]
    return [
        "<h2>Sensitivity</h2>",
        drawn(response.index_bars(design, found[:MOST_PANELS]), folder / "sensitivity.svg", _INDICES),
        table(["treatment", "outcome", "key", *response.INDEX_NAMES[design]], cells),
    ]


def _points(rows: Sequence[Row], keys: list[str], outcomes: list[Outcome]) -> list[str]:
    parts = list(group(rows, lambda row: (row["point"], row["treatment"])).values())
    treatments = len({row["treatment"] for row in rows}) > 1
    head = [
        *map(response.short, keys),
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


def _seeds(rows: Sequence[Row], keys: list[str], outcomes: list[Outcome]) -> list[str]:
    """Return the section on the number of seeds: for means at each point, and the effects of treatments there."""
    parts, effects = group(rows, lambda row: (row["point"], row["treatment"])), []
    for (point, treatment), part in parts.items():
        if len(part) == 1:
            continue
        world = parts.get((point, UNTREATED)) if treatment != UNTREATED else None
        values = ", ".join(f"{response.short(key)} = {part[0][key]}" for key in keys)
        arm = treatment if world is None else f"{treatment} − {UNTREATED}"
        for outcome in outcomes:
            name = ": ".join(filter(None, (values, arm, outcome.label)))
            other = None if world is None else response.of_seeds(world, outcome.column)
            effects.append(Effect(name, response.of_seeds(part, outcome.column), other, outcome.share))
    crossed = all(len({row["training_seed"] for row in part}) > 1 for part in parts.values())
    return seeds_section(effects, "training seeds" if crossed else "seeds")


def _cell(x: Interval) -> str:
    return number(x.value) if x.low != x.low else interval(x)


def _origin(sweep: Sweep, rows: Sequence[Row]) -> list[str]:
    commits = sorted({str(row["git_commit"])[:12] for row in rows})
    seeds: dict[str, Any] = {kind: sweep.content["plan"][f"{kind}_seeds"] for kind in ("world", "training")}
    words = "; ".join(f"{kind} seeds {', '.join(map(str, own))}" for kind, own in seeds.items() if own)
    hours = sum(row["seconds"] for row in rows) / 3600
    return [
        "<h2>How it was made</h2>",
        f"<p>Plan {escape(sweep.content['source'])} ({sweep.hash[:16]}), {escape(words)}; "
        f"commit {escape(', '.join(commits))}; {number(hours)} core hours, "
        f"machines: {len({row['host'] for row in rows})}. Each run has a folder in jobs/ and a row in "
        "runs.parquet.</p>",
    ]
