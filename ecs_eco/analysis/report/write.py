"""The whole report: its order, what was run, and how to run it again."""

import json
import shlex
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path
from typing import Any

from ecs_eco.analysis import depth_figures, figures, flows, genes_figures, matter, measures
from ecs_eco.analysis.cycles import CycleStatistics, cycle_statistics
from ecs_eco.analysis.extinction import opening
from ecs_eco.analysis.land import land_at
from ecs_eco.analysis.page import drawn, number, page, table, verdict, write_text
from ecs_eco.analysis.relief import Relief
from ecs_eco.analysis.report import tables, training
from ecs_eco.analysis.report.against import blocks as against_blocks
from ecs_eco.analysis.report.against import of_run
from ecs_eco.analysis.report.tables import last_snapshot
from ecs_eco.analysis.runs import DIED, Series, load_series
from ecs_eco.analysis.style import Figure, as_delivered, colors_of
from ecs_eco.config.measurements import Outside, read_outside
from ecs_eco.engine.errors import ConfigError
from ecs_eco.engine.garbage import uncollected


def write_report(
    run_dir: Path | str,
    out: Path | str | None = None,
    against: Path | str | None = None,
    match: Mapping[str, str] | None = None,
) -> Path:
    """Write report.html and figures/*.svg into a run folder, or into `out`,
    and return the path of the report; beside an outside series, a CSV file, if `against` names one, whose
    columns `match` tells the species of (`ecs_eco.analysis.against`), else that of the world's [data].

    Reads the manifest and the Parquet parts; events are streamed, so that millions of births fit in little
    memory. ConfigError for an outside series that cannot be used, FileNotFoundError where the folder holds
    no run, RecordingError where a file of it is damaged.
    """
    with as_delivered({}), uncollected():  # figures are full of circles, and few
        return _written(Path(run_dir), out, against, match)


def _written(
    run: Path, out: Path | str | None, against: Path | str | None, match: Mapping[str, str] | None
) -> Path:
    place = run if out is None else Path(out)
    series = load_series(run)
    outside = (
        of_run(run, series)
        if against is None
        else read_outside(against, [*series.species, *series.reporters], match)
    )
    cycles = cycle_statistics(series) if len(series.ticks) else CycleStatistics(series.species, 0, False)
    pictures = draw(run, series, cycles, place)
    title = f"{series.manifest.get('title') or series.manifest.get('world', 'A run')}"
    blocks = [
        f"<h1>{escape(title)}</h1>",
        verdict(opening(series), not series.present.any() or not series.persisted),
        f"<p class='under'>{escape(_what(series))}</p>",
        pictures.get("populations", ""),
        *(("<h2>Interventions</h2>", done) if (done := tables.interventions(series)) else ()),
        "<h2>Numbers</h2>",
        tables.numbers(series, tables.ages_at_death(run)),
        *(
            ("<h2>Measured</h2>", measures.rows(series), pictures.get("measured", ""))
            if series.reporters and len(series.ticks)
            else ()
        ),
        "<h2>Cycles</h2>",
        tables.cycles(series, cycles),
        *(pictures.get(name, "") for name in ("spectra", "lags", "phase")),
        *_beside(series, outside, place, against is not None),
        "<h2>What they died of</h2>",
        tables.deaths(series),
        pictures.get("deaths", ""),
        "<h2>Energy</h2>",
        tables.energy(series),
        pictures.get("energy", ""),
        *flows.blocks(series, place),
        *matter.blocks(run, series, place),
        *depth_figures.blocks(run, series, place),
        *training.blocks(run, series, place),
        *genes_figures.blocks(run, series, place),
        *(("<h2>Where they are</h2>", pictures["positions"]) if "positions" in pictures else ()),
        "<h2>How to run it again</h2>",
        _settings(series.manifest),
    ]
    return write_text(place / "report.html", page(title, *blocks))


def _beside(series: Series, outside: Outside | None, place: Path, asked: bool) -> list[str]:
    """The part on outside series; of a run too short for it, why there is none, unless it was asked for."""
    try:
        return against_blocks(series, outside, place)
    except ConfigError as error:
        if asked:
            raise
        reason = f"{error.problems[0].value or ''} {error.problems[0].what}".strip()
        return ["<h2>Beside the outside series</h2>", f"<p>Not shown: {escape(reason)}.</p>"]


def _what(series: Series) -> str:
    m = series.manifest
    length = f"{len(series.ticks):,} ticks of {number(series.dt)} s"
    broken = (
        "" if m.get("finished", True) else f" of {m.get('ticks', 0):,} asked for: the run was interrupted"
    )
    wall = f", {m['wall_seconds']:,.1f} s of computing" if m.get("wall_seconds") else ""
    return f"World {m.get('world', '?')}, seed {m.get('seed', '?')}, {length}{broken}{wall}."


def rerun(m: Mapping[str, Any]) -> str:
    """The command that runs a world like this from its manifest; changes made with --set are not in it."""
    portable = " --portable" if m.get("target", {}).get("mode") == "portable" else ""
    words = [
        f"ecs-eco{portable} run",
        shlex.quote(str(m.get("world", "WORLD"))),
        f"--seed {m.get('seed', 0)} --ticks {m.get('ticks', 0)}",
    ]
    if m.get("policies", "trained") != "trained":
        words.append(f"--policies {shlex.quote(str(m['policies']))}")
    if m.get("config", {}).get("code"):
        words.append("--trust")
    if m.get("learn") is not None:
        words.append("--learn" if m["learn"] else "--no-learn")
    return " ".join([*words, "--out DIR"])


def _settings(m: Mapping[str, Any]) -> str:
    command = m.get("command") or rerun(m)
    versions = ", ".join(f"{k} {v}" for k, v in m.get("versions", {}).items())
    rows = [
        ["commit", m.get("git_commit") or "not known"],
        ["configuration", m.get("config_hash", "–")],
        ["policies", m.get("policies", "–")],
    ]
    rows.append(["versions", versions or "–"])
    config = escape(json.dumps(m.get("config", {}), indent=2, ensure_ascii=False))
    return (
        f"<pre>{escape(command)}</pre>{table(['', ''], rows)}<details><summary>All "
        f"settings</summary><pre>{config}</pre></details>"
    )


Drawn = tuple[str, Figure, str]  # name of the file, figure, caption


def draw(run: Path, series: Series, cycles: CycleStatistics, place: Path) -> dict[str, str]:
    """The figures for which this run has data, as HTML by name; they are written below `place`."""
    if not len(series.ticks) or not len(series.species):
        return {}
    found = [*_numbers(series), *_cycles(series, cycles), *_flows(series), *_places(run, series)]
    return {name: drawn(f, place / "figures" / f"{name}.svg", caption) for name, f, caption in found}


def _numbers(series: Series) -> Iterator[Drawn]:
    marked = "; a dashed line marks an intervention" if figures.interventions(series) else ""
    yield (
        "populations",
        figures.populations(series),
        f"Numbers over time. A cross marks the end of a species{marked}.",
    )
    if series.reporters:
        yield "measured", measures.figure(series), "What the world's reporters measured, over time."


def _cycles(series: Series, cycles: CycleStatistics) -> Iterator[Drawn]:
    hue = colors_of(series)
    present = [s for s, here in zip(series.species, series.present, strict=True) if here]
    pairs = list(zip(present, present[1:], strict=False))
    peaks = {s: peak for s, peak in cycles.peaks.items() if peak is not None}
    if peaks:
        band = "the band is that of a population that drifts without cycling"
        yield (
            "spectra",
            figures.spectra(peaks, hue),
            f"Spectra. A cycle is a peak above the grey band; {band}.",
        )
    if cycles.cycling() and cycles.period and pairs and all(f"{a}→{b}" in cycles.lags for a, b in pairs):
        caption = "Correlation of two species, one shifted in time; right of zero the consumer follows."
        yield "lags", figures.lags(series, pairs, cycles.period), caption
    if pairs and len(series.ticks) > 2:
        turns = "Cycles go round, counter-clockwise where the consumer follows"
        yield "phase", figures.phase(series, pairs), f"Two species against each other. {turns}."


def _flows(series: Series) -> Iterator[Drawn]:
    if any(series.columns[DIED + c].any() for c in series.causes):
        yield "deaths", figures.deaths(series), "Deaths per tick by cause."
    if "stock_after" in series.columns and series.columns["stock_after"].any():
        yield "energy", figures.energy(series), "Energy per tick: inflows above zero, outflows below."


def _places(run: Path, series: Series) -> Iterator[Drawn]:
    size = series.manifest.get("config", {}).get("space", {}).get("size")
    snapshot = last_snapshot(run, series.species) if size else None
    if size and snapshot:
        hue = colors_of(series)
        land = land_at(series.manifest["config"], series.manifest.get("intervened", ()), snapshot[0], run)
        relief = Relief.kept(run, series.manifest["config"])
        seen = [
            word
            for word, there in (
                ("hills in the light of the upper left, blue is water", relief is not None),
                ("strips are roads", land["roads"]),
                ("dashed lines fences", land["fences"]),
                ("dotted borders areas of harvest (red) and planting (green)", land["areas"]),
            )
            if there
        ]
        yield (
            "positions",
            figures.positions(snapshot[1], size, hue, land=land, relief=relief),
            f"All organisms at tick {snapshot[0]:,}{'; ' * bool(seen)}{', '.join(seen)}.",
        )
