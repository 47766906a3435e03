"""The whole report: its sections in order, the run's settings, and the command that repeats the run."""

import json
import shlex
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis import depth_figures, figures, flows, genes_figures, learning, matter, measures
from ecs_eco.analysis.cycles import CycleStatistics, Lag, cycle_statistics
from ecs_eco.analysis.extinction import opening, swings
from ecs_eco.analysis.land import land_at
from ecs_eco.analysis.page import Markup, bullets, drawn, number, page, table, verdict, write_text
from ecs_eco.analysis.palette import ON_DARK
from ecs_eco.analysis.relief import Relief
from ecs_eco.analysis.report import against as outside_series
from ecs_eco.analysis.runs import DIED, Series, load_series, parts, tables
from ecs_eco.analysis.spectrum import Peak
from ecs_eco.analysis.style import Figure, as_delivered, colors_of
from ecs_eco.compiled.garbage import uncollected
from ecs_eco.config.measurements import Outside, read_outside
from ecs_eco.engine.errors import ConfigError
from ecs_eco.record import seal
from ecs_eco.record.ledger import LEDGER, imbalance
from ecs_eco.record.parquet import read_part, to_codes, to_numpy

FEW_PERIODS = 5
"""If a run contains fewer periods, the report recommends a longer run."""


def interventions(series: Series) -> str:
    """Return a table of interventions, in which repeated interventions share a row, or "" if there are none."""
    ticks: dict[str, list[int]] = {}
    for tick, text in figures.interventions(series):
        ticks.setdefault(text, []).append(tick)
    when = {text: f"{at[0]:,}" if len(at) == 1 else f"{at[0]:,} to {at[-1]:,}" for text, at in ticks.items()}
    rows = [[when[text], f"{len(at):,}", text] for text, at in ticks.items()]
    return table(["tick", "times", "what"], rows) if rows else ""


def numbers(series: Series, ages: Mapping[str, tuple[int, float]]) -> str:
    """Return a table of population sizes, births, deaths and lifetimes; `ages` is from `ages_at_death`."""
    if not len(series.ticks):
        return "<p>The run has no ticks.</p>"
    head = ["species", "first tick", "mean", "minimum", "maximum", "last tick", "births", "refused", "deaths"]
    head += ["mean age at death [s]", "life expectancy [s]"]
    note = (
        "“Refused” counts births prevented by max_count. Life expectancy is the total time lived divided by "
        "the number of deaths; unlike the age at death, it includes organisms that are still alive."
    )
    rows = [_numbers_of(series, i, ages) for i in range(len(series.species))]
    return f"{table(head, rows)}<p class='under'>{note}</p>"


def _numbers_of(series: Series, i: int, ages: Mapping[str, tuple[int, float]]) -> list[str]:
    n, species = series.n[:, i], series.species[i]
    sums = [
        f"{series.columns[c][:, i].sum():,.0f}" if c in series.columns else "–"
        for c in ("births", "refused", "deaths")
    ]
    died = series.columns["deaths"][:, i].sum() if "deaths" in series.columns else 0
    expected = n.sum() * series.dt / died if died else np.nan
    hue = colors_of(series)[species]
    both = f"--light:{hue};--dark:{ON_DARK.get(hue, hue)}"
    name = Markup(f"<span class='swatch' style='{both}'></span>{escape(species)}")
    over_time = (number(round(x)) for x in (n[0], n.mean(), n.min(), n.max(), n[-1]))
    return [name, *over_time, *sums, number(ages.get(species, (0, np.nan))[1]), number(expected)]


def cycles(series: Series, statistics: CycleStatistics) -> str:
    """Return the section on cycles: which species cycle, their periods, and the lags between species."""
    if not statistics.enough:
        return (
            f"<p>The run is too short to look for cycles: {statistics.ticks:,} ticks remain after the first "
            "tenth and before the first extinction. A run needs at least ten periods, usually thousands of "
            "ticks.</p>"
        )
    cycling = statistics.cycling()
    items = bullets(_cycle(s, statistics.peaks[s], s in cycling) for s in statistics.species)
    method = (
        "<p class='under'>p is the probability of a spectral peak this high, at any of the periods tested, "
        f"in a population that drifts and relaxes without cycling ({statistics.ticks:,} ticks, excluding the "
        "first tenth). One run is one replicate; <code>ecs-eco compare</code> pools seeds.</p>"
    )
    if not cycling or not statistics.period:
        return items + method
    lags = bullets(_lag(pair, x, statistics.period) for pair, x in statistics.lags.items())
    who = f"<p>Lags between species at the period of {statistics.period:,.0f} ticks (95% intervals):</p>"
    return items + who + lags + method


def _cycle(species: str, peak: Peak | None, cycles: bool) -> str:
    if peak is None:
        return f"{species}: its number is constant."
    p = f"p ≤ {peak.p:.3f}" if peak.p <= 0.002 else f"p = {peak.p:.2g}"
    if not cycles and peak.p <= 0.05:
        why = f"the series contains this period only {peak.held:,.1f} times"
        if peak.slower > 1:
            why = f"slower swings have {peak.slower:,.1f} times its variance"
        return f"{species}: no cycle. Its spectrum has a bump at {peak.period:,.0f} ticks ({p}), but {why}."
    if not cycles:
        return f"{species}: no cycle beyond red noise ({p})."
    few = f" With fewer than {FEW_PERIODS} periods, this is uncertain; use a longer run."
    more = few * (peak.n_periods < FEW_PERIODS)
    return f"{species} cycles: a period of {peak.period:,.0f} ticks, {peak.n_periods:.1f} periods, {p}.{more}"


def _lag(pair: str, lag: Lag, period: float) -> str:
    a, b = pair.split("→")
    loose = "; loosely coupled" if lag.coherence < 0.5 else ""
    share = f"{lag.share:.2f} of a period ({lag.low:.2f} to {lag.high:.2f})"
    ticks = f"about {lag.share * period:,.0f} ticks"
    return f"{b} follows {a} by {share}, {ticks}; coherence {lag.coherence:.2f}{loose}."


def deaths(series: Series) -> str:
    """Return a table with a row for each species and cause of death."""
    rows = []
    for i, s in enumerate(series.species):
        counts = {c: series.columns[DIED + c][:, i].sum() for c in series.causes}
        total = sum(counts.values())
        rows += [
            [s, c, f"{k:,.0f}", f"{k / total:.1%}"]
            for c, k in sorted(counts.items(), key=lambda x: -x[1])
            if k
        ]
    return table(["species", "cause", "deaths", "share"], rows) if rows else "<p>No organism died.</p>"


def energy(series: Series) -> str:
    """Return a sentence on whether the energy ledger closes, and a table of total flows by species."""
    flows = [c for c in LEDGER if c not in ("stock_before", "stock_after")]
    if not len(series.ticks) or any(c not in series.columns for c in LEDGER):
        return "<p>The run has no energy ledger.</p>"
    gaps = ledger_gap(series)
    worst = max(gaps, key=lambda s: gaps[s][1])
    gap, share, tick = gaps[worst]
    kept = "closes" if share < 1e-5 else "DOES NOT CLOSE"
    rows = [
        [s, *(number(series.columns[c][:, i].sum()) for c in flows), f"{gaps[s][0]:.2g}"]
        for i, s in enumerate(series.species)
    ]
    where = f"{share:.1e} of the stock ({escape(worst)}, tick {tick:,})"
    head = ["species", "endowed", "taken in", "burned", "given", "held at death", "largest gap"]
    return f"<p>The ledger {kept}: the largest gap in any tick is {gap:.2g}, {where}.</p>{table(head, rows)}"


def ages_at_death(run: Path | str) -> dict[str, tuple[int, float]]:
    """Return each species' number of deaths and mean age at death [s], streamed from deaths/*.parquet."""
    totals: dict[str, np.ndarray] = {}
    for batch in tables(run, "deaths", ["species", "age"], batches=True):
        names, code = to_codes(batch["species"])
        age = to_numpy(batch["age"])
        for i, s in enumerate(names):
            here = age[code == i]
            totals[s] = totals.get(s, np.zeros(2)) + (len(here), here.sum(dtype=np.float64))
    return {s: (int(n), float(total / n) if n else np.nan) for s, (n, total) in totals.items()}


def last_snapshot(run: Path | str, species: tuple[str, ...]) -> tuple[int, dict[str, np.ndarray]] | None:
    """Return the last snapshot's tick and positions (n, 3) [m] by species, or None if there is none."""
    files = parts(run, "snapshots")
    if not files:
        return None
    rows = read_part(files[-1], ["tick", "species", "x", "y", "z"], seal.has_seals(Path(run)))
    if not len(rows):
        return None
    ticks, place = to_numpy(rows["tick"]), np.stack([to_numpy(rows[c]) for c in "xyz"], 1)
    tick, (names, code) = int(ticks.max()), to_codes(rows["species"])
    of = {s: place[(code == names.index(s)) & (ticks == tick)] for s in species if s in names}
    return tick, {s: at for s, at in of.items() if len(at)}


def ledger_gap(series: Series) -> dict[str, tuple[float, float, int]]:
    """Return each species' largest gap in its energy ledger, in a tick or between ticks: the energy, its share
    of the stock, and the tick."""
    c = series.columns
    gap: np.ndarray = np.abs(imbalance(c))
    gap[1:] = np.maximum(gap[1:], np.abs(c["stock_before"][1:] - c["stock_after"][:-1]))
    worst = gap.argmax(0)
    scale = np.maximum(np.abs(c["stock_after"]).max(0), 1.0)
    return {
        s: (float(gap[worst[i], i]), float(gap[worst[i], i] / scale[i]), int(series.ticks[worst[i]]))
        for i, s in enumerate(series.species)
    }


def write_report(
    run_dir: Path | str,
    out: Path | str | None = None,
    against: Path | str | None = None,
    match: Mapping[str, str] | None = None,
) -> Path:
    """Write report.html and figures/*.svg for a run, and return the path of the report.

    Parameters
    ----------
    run_dir : str or Path
        Folder of a run.
    out : str or Path, optional
        Folder for the report; default: the folder of the run.
    against : str or Path, optional
        CSV file with an outside series to compare the run with; default: the world's `[data]`.
    match : Mapping of str to str, optional
        Columns of that file → the species or reporters to compare them with.

    Returns
    -------
    Path

    Raises
    ------
    ConfigError
        If the outside series cannot be used.
    FileNotFoundError
        If the folder contains no run.
    RecordingError
        If a file is damaged.

    Notes
    -----
    Events are streamed, so even millions of births need little memory.

    Examples
    --------
    >>> from ecs_eco.analysis.report import write_report
    >>> from ecs_eco.runs.run import run_to_folder
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=20, out="my-run", report=False)
    >>> write_report("my-run").name
    'report.html'
    """
    with as_delivered({}), uncollected():  # saves time; reference cycles of a few figures need little memory
        return _written(Path(run_dir), out, against, match)


def _written(
    run: Path, out: Path | str | None, against: Path | str | None, match: Mapping[str, str] | None
) -> Path:
    place = run if out is None else Path(out)
    series = load_series(run)
    outside = (
        outside_series.of_run(run, series)
        if against is None
        else read_outside(against, [*series.species, *series.reporters], match)
    )
    found = cycle_statistics(series) if len(series.ticks) else CycleStatistics(series.species, 0, False)
    pictures = draw(run, series, found, place)
    title = f"{series.manifest.get('title') or series.manifest.get('world', 'A run')}"
    blocks = [
        f"<h1>{escape(title)}</h1>",
        verdict([*opening(series), *swings(series)], not series.present.any() or not series.persisted),
        f"<p class='under'>{escape(_what(series))}</p>",
        pictures.get("populations", ""),
        *(("<h2>Interventions</h2>", done) if (done := interventions(series)) else ()),
        "<h2>Numbers</h2>",
        numbers(series, ages_at_death(run)),
        *learning.blocks(run, series, place),
        *(
            ("<h2>Measured</h2>", measures.rows(series), pictures.get("measured", ""))
            if series.reporters and len(series.ticks)
            else ()
        ),
        *measures.fields(run),
        "<h2>Cycles</h2>",
        cycles(series, found),
        *(pictures.get(name, "") for name in ("spectra", "lags", "phase")),
        *_beside(series, outside, place, against is not None),
        "<h2>Causes of death</h2>",
        deaths(series),
        pictures.get("deaths", ""),
        "<h2>Energy</h2>",
        energy(series),
        pictures.get("energy", ""),
        *flows.blocks(series, place),
        *matter.blocks(run, series, place),
        *depth_figures.blocks(run, series, place),
        *genes_figures.blocks(run, series, place),
        *(("<h2>Positions</h2>", pictures["positions"]) if "positions" in pictures else ()),
        "<h2>How to run it again</h2>",
        _settings(series.manifest),
    ]
    return write_text(place / "report.html", page(title, *blocks))


def _beside(series: Series, outside: Outside | None, place: Path, asked: bool) -> list[str]:
    """Return the section on the outside series or, unless it was requested, the reason for omitting it."""
    try:
        return outside_series.blocks(series, outside, place)
    except ConfigError as error:
        if asked:
            raise
        reason = f"{error.problems[0].value or ''} {error.problems[0].what}".strip()
        return ["<h2>Comparison with the outside series</h2>", f"<p>Not shown: {escape(reason)}.</p>"]


def _what(series: Series) -> str:
    m = series.manifest
    planned, broken = (
        ("", "") if m.get("finished", True) else (f" of {m.get('ticks', 0):,}", " (interrupted)")
    )
    length = f"{len(series.ticks):,}{planned} ticks of {number(series.dt)} s"
    wall = f", {m['wall_seconds']:,.1f} s of computing time" if m.get("wall_seconds") else ""
    return f"World {m.get('world', '?')}, seed {m.get('seed', '?')}, {length}{broken}{wall}."


def rerun(m: Mapping[str, Any]) -> str:
    """Return the command that runs this world again, from its manifest, without changes made by --set."""
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
        ["commit", m.get("git_commit") or "unknown"],
        ["configuration", m.get("config_hash", "–")],
        ["policies", m.get("policies", "–")],
        ["versions", versions or "–"],
    ]
    config = escape(json.dumps(m.get("config", {}), indent=2, ensure_ascii=False))
    return (
        f"<pre>{escape(command)}</pre>{table(['', ''], rows)}<details><summary>All "
        f"settings</summary><pre>{config}</pre></details>"
    )


Drawn = tuple[str, Figure, str]  # file name, figure, caption


def draw(run: Path, series: Series, cycles: CycleStatistics, place: Path) -> dict[str, str]:
    """Return the figures for which this run has data, as HTML by name, and write them to `place`."""
    if not len(series.ticks) or not len(series.species):
        return {}
    found = [*_curves(series), *_cycles(series, cycles), *_places(run, series)]
    return {name: drawn(f, place / "figures" / f"{name}.svg", caption) for name, f, caption in found}


def _curves(series: Series) -> Iterator[Drawn]:
    marked = "; a dashed line marks an intervention" if figures.interventions(series) else ""
    text = f"Numbers over time. A cross marks an extinction{marked}."
    yield "populations", figures.populations(series), text
    if series.reporters:
        yield "measured", measures.figure(series), "Values of the world's reporters over time."
    if any(series.columns[DIED + c].any() for c in series.causes):
        yield "deaths", figures.deaths(series), "Deaths per tick by cause."
    if "stock_after" in series.columns and series.columns["stock_after"].any():
        yield (
            "energy",
            figures.energy(series),
            "Energy per tick: inflows above zero, outflows below; energy held at death includes what is eaten.",
        )


def _cycles(series: Series, cycles: CycleStatistics) -> Iterator[Drawn]:
    present = series.there
    pairs = list(zip(present, present[1:], strict=False))
    peaks = {s: peak for s, peak in cycles.peaks.items() if peak is not None}
    if peaks:
        text = "Spectra. A cycle is a peak above the gray band, which shows a population that "
        yield "spectra", figures.spectra(peaks, colors_of(series)), text + "drifts without cycling."
    if cycles.cycling() and cycles.period and pairs and all(f"{a}→{b}" in cycles.lags for a, b in pairs):
        caption = "Correlation of two species shifted in time; to the right of zero, the consumer follows."
        yield "lags", figures.lags(series, pairs, cycles.period), caption
    if pairs and len(series.ticks) > 2:
        turns = "Cycles appear as loops, counterclockwise if the consumer follows"
        yield "phase", figures.phase(series, pairs), f"Two species plotted against each other. {turns}."


def _places(run: Path, series: Series) -> Iterator[Drawn]:
    size = series.manifest.get("config", {}).get("space", {}).get("size")
    snapshot = last_snapshot(run, series.species) if size else None
    if size and snapshot:
        land = land_at(series.manifest["config"], series.manifest.get("intervened", ()), snapshot[0], run)
        relief = Relief.kept(run, series.manifest["config"])
        seen = ["hills are lit from the upper left, blue is water"] * (relief is not None)
        seen += ["strips are roads"] * bool(land["roads"]) + ["dashed lines are fences"] * bool(
            land["fences"]
        )
        seen += ["dotted borders are areas of harvest (red) and planting (green)"] * bool(land["areas"])
        figure = figures.positions(snapshot[1], size, colors_of(series), land=land, relief=relief)
        yield (
            "positions",
            figure,
            f"All organisms at tick {snapshot[0]:,}{'; ' * bool(seen)}{', '.join(seen)}.",
        )
