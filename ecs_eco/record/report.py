"""The report of a run folder: one HTML page that a biologist can read, and its figures."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from ecs_eco.analysis import figures
from ecs_eco.analysis.carriers import carriers, told_apart
from ecs_eco.analysis.cycles import CycleStatistics, cycle_statistics
from ecs_eco.analysis.extinction import opening
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.page import Markup, number, page, picture, table, write_text
from ecs_eco.analysis.runs import DIED, Series, load_series, parts
from ecs_eco.record import report_sea, seal
from ecs_eco.record.arrow import open_part, read_part

FEW_PERIODS = 5
"""Below so many periods in a run we say that a longer one is needed."""


def write_report(run_dir: Path | str) -> Path:
    """Write report.html and figures/*.png into a run folder and return the path of the report.

    Reads the manifest and the Parquet parts; events are streamed, so that millions of births fit in little memory.
    FileNotFoundError where the folder holds no run, RecordingError where a file of it is damaged.
    """
    run = Path(run_dir)
    series = load_series(run)
    cycles = cycle_statistics(series) if len(series.ticks) else CycleStatistics(series.species, 0, False)
    pictures = _draw(run, series, cycles)
    title = f"{series.manifest.get('title') or series.manifest.get('world', 'A run')}"
    blocks = [
        f"<h1>{escape(title)}</h1>",
        _verdict(series),
        f"<p class='under'>{escape(_what(series))}</p>",
        pictures.get("populations", ""),
        *(("<h2>Interventions</h2>", done) if (done := _interventions(series)) else ()),
        "<h2>Numbers</h2>",
        _numbers(series, ages_at_death(run)),
        "<h2>Cycles</h2>",
        _cycles(series, cycles),
        *(pictures.get(name, "") for name in ("spectra", "lags", "phase")),
        "<h2>What they died of</h2>",
        _deaths(series),
        pictures.get("deaths", ""),
        "<h2>Energy</h2>",
        _energy(series),
        pictures.get("energy", ""),
        *report_sea.blocks(run, series),
        *(("<h2>Genes</h2>", *drawn) if (drawn := [p for name, p in pictures.items() if name.startswith("carriers")]) else ()),
        *(("<h2>Where they are</h2>", pictures["positions"]) if "positions" in pictures else ()),
        "<h2>How to run it again</h2>",
        _settings(series.manifest),
    ]
    return write_text(run / "report.html", page(title, *blocks))


def ages_at_death(run: Path | str) -> dict[str, tuple[int, float]]:
    """Deaths and mean age at death [s] of each species, streamed from deaths/*.parquet."""
    totals: dict[str, np.ndarray] = {}
    sealed = seal.has_seals(Path(run))
    for file in parts(run, "deaths"):
        for batch in open_part(file, sealed).iter_batches(1 << 17, columns=["species", "age"]):
            summed = pa.Table.from_batches([batch]).group_by("species").aggregate([("age", "count"), ("age", "sum")])
            for row in summed.to_pylist():
                got = totals.setdefault(row["species"], np.zeros(2))
                got += row["age_count"], row["age_sum"] or 0.0
    return {s: (int(n), float(total / n) if n else np.nan) for s, (n, total) in totals.items()}


def last_snapshot(run: Path | str, species: tuple[str, ...]) -> tuple[int, dict[str, np.ndarray]] | None:
    """Tick and positions (n, 3) [m] by species of the last snapshot; None where there is none."""
    files = parts(run, "snapshots")
    if not files:
        return None
    found = read_part(files[-1], ["tick", "species", "x", "y", "z"], seal.has_seals(Path(run)))
    if not len(found):
        return None
    tick = pc.max(found["tick"]).as_py()
    found = found.filter(pc.equal(found["tick"], tick))
    name = found["species"].cast(pa.string())
    of = {s: found.filter(pc.equal(name, s)) for s in species}
    return tick, {s: np.stack([t[c].to_numpy() for c in "xyz"], 1) for s, t in of.items() if len(t)}


def _draw(run: Path, series: Series, cycles: CycleStatistics) -> dict[str, str]:
    """The figures that this run has something for, as HTML by name."""
    if not len(series.ticks) or not len(series.species):
        return {}
    out = {}

    def add(name: str, figure: Any, caption: str) -> None:
        out[name] = picture(figures.save(figure, run / "figures" / f"{name}.png"), caption)

    hue = figures.colors(series.species, series.manifest.get("colors"))
    alive = [s for s, here in zip(series.species, series.present, strict=True) if here]
    pairs = list(zip(alive, alive[1:], strict=False))
    marked = ", a dashed line an intervention" if figures.interventions(series) else ""
    add("populations", figures.populations(series), f"Numbers over time. A cross marks the end of a species{marked}.")
    peaks = {s: peak for s, peak in cycles.peaks.items() if peak is not None}
    if peaks:
        add(
            "spectra",
            figures.spectra(peaks, hue),
            "Spectra. A cycle is a peak that leaves the grey band; the band is what drifting without cycling gives.",
        )
    if cycles.cycling() and cycles.period and pairs and not [p for p in pairs if f"{p[0]}→{p[1]}" not in cycles.lags]:
        add(
            "lags",
            figures.lags(series, pairs, cycles.period),
            "Correlation of two species when one is moved in time; right of zero the consumer follows.",
        )
    if pairs and len(series.ticks) > 2:
        add(
            "phase",
            figures.phase(series, pairs),
            "Two species against each other. Cycles turn around a point, counter-clockwise where the consumer follows.",
        )
    if any(series.columns[DIED + c].any() for c in series.causes):
        add("deaths", figures.deaths(series), "Deaths per tick by cause.")
    if "stock_after" in series.columns and series.columns["stock_after"].any():
        add("energy", figures.energy(series), "Energy per tick: what comes in above zero, what goes out below.")
    for s, genes in genes_shown(series.manifest).items():
        lineage = Lineage.read(run)
        counted = [lineage.frequencies(s, gene, max(1, len(series.ticks) // 500)) for gene in genes] if s in lineage.species else []
        if counted:
            caption = "Who has the value of a gene's first codon is without it; all organisms are the grey line."
            add(f"carriers-{series.index(s)}", carriers(counted, s), f"Number of {s} that carry each gene. {caption}")
    size = series.manifest.get("config", {}).get("space", {}).get("size")
    snapshot = last_snapshot(run, series.species) if size else None
    if size and snapshot:
        add("positions", figures.positions(snapshot[1], size, hue), f"Everybody at tick {snapshot[0]:,}.")
    return out


def genes_shown(manifest: Mapping[str, Any]) -> dict[str, list[str]]:
    """The genes of each species that have few enough values for a figure."""
    genomes = manifest.get("genomes", {})
    found = {s: [g["name"] for g in genome["genes"] if told_apart(g)] for s, genome in genomes.items()}
    return {s: names for s, names in found.items() if names}


def _what(series: Series) -> str:
    m = series.manifest
    length = f"{len(series.ticks):,} ticks of {number(series.dt)} s"
    broken = "" if m.get("finished", True) else f" of {m.get('ticks', 0):,} asked for: the run was interrupted"
    wall = f", {m['wall_seconds']:,.1f} s of computing" if m.get("wall_seconds") else ""
    return f"World {m.get('world', '?')}, seed {m.get('seed', '?')}, {length}{broken}{wall}."


def _verdict(series: Series) -> str:
    """What the report opens with: whether all species persisted, and else when and of what they died out."""
    lines = opening(series)
    lost = not series.present.any() or not series.persisted
    return f"<div class='verdict{' lost' if lost else ''}'>" + "".join(f"<p>{escape(x)}</p>" for x in lines) + "</div>"


def _interventions(series: Series) -> str:
    """A table of what was done to the world; what was done many times is one row. "" where nothing was."""
    ticks: dict[str, list[int]] = {}
    for tick, what in figures.interventions(series):
        ticks.setdefault(what, []).append(tick)
    rows = [[f"{at[0]:,}" if len(at) == 1 else f"{at[0]:,} to {at[-1]:,}", f"{len(at):,}", what] for what, at in ticks.items()]
    return table(["tick", "times", "what"], rows) if rows else ""


def _numbers(series: Series, ages: Mapping[str, tuple[int, float]]) -> str:
    if not len(series.ticks):
        return "<p>The run has no ticks.</p>"
    hue = figures.colors(series.species, series.manifest.get("colors"))
    rows = []
    for i, s in enumerate(series.species):
        n = series.n[:, i]
        sums = [f"{series.columns[c][:, i].sum():,.0f}" if c in series.columns else "–" for c in ("births", "deaths")]
        died = series.columns["deaths"][:, i].sum() if "deaths" in series.columns else 0
        expected = n.sum() * series.dt / died if died else np.nan
        name = Markup(f"<span class='swatch' style='background:{escape(hue[s])}'></span>{escape(s)}")
        rows.append(
            [
                name,
                *(number(round(x)) for x in (n[0], n.mean(), n.min(), n.max(), n[-1])),
                *sums,
                number(ages.get(s, (0, np.nan))[1]),
                number(expected),
            ]
        )
    head = [
        "species",
        "first tick",
        "mean",
        "least",
        "most",
        "last tick",
        "births",
        "deaths",
        "mean age at death [s]",
        "life expectancy [s]",
    ]
    note = (
        "Life expectancy is time lived by all, divided by deaths: unlike the age at death it counts those still alive."
    )
    return f"{table(head, rows)}<p class='under'>{note}</p>"


def _cycles(series: Series, found: CycleStatistics) -> str:
    if not found.enough:
        return (
            f"<p>The run is too short to look for cycles: {found.ticks:,} ticks are left after the first tenth and "
            "before the first extinction. Ten periods or more are needed, in practice thousands of ticks.</p>"
        )
    lines, cycling = [], found.cycling()
    for s in found.species:
        peak = found.peaks[s]
        if peak is None:
            lines.append(f"{s}: its number does not change.")
        elif s in cycling:
            few = (
                f" Fewer than {FEW_PERIODS} periods: a longer run is needed to be sure."
                if peak.n_periods < FEW_PERIODS
                else ""
            )
            lines.append(
                f"{s} cycles: a period of {peak.period:,.0f} ticks, {peak.n_periods:.1f} periods, p {_p(peak.p)}.{few}"
            )
        else:
            lines.append(f"{s}: no cycle beyond red noise (p {_p(peak.p)}).")
    items = "".join(f"<li>{escape(x)}</li>" for x in lines)
    method = (
        "<p class='under'>p is the chance of so high a spectral peak, at any of the periods looked at, in a population that "
        f"drifts and relaxes without cycling ({found.ticks:,} ticks, without the first tenth). One run is one replicate: "
        "<code>ecs-eco compare</code> pools seeds.</p>"
    )
    if not cycling or not found.period:
        return f"<ul>{items}</ul>{method}"
    lags = "".join(f"<li>{escape(_lag(pair, x, found.period))}</li>" for pair, x in found.lags.items())
    return f"<ul>{items}</ul><p>Who follows whom, at the period of {found.period:,.0f} ticks (95 % intervals):</p><ul>{lags}</ul>{method}"


def _p(p: float) -> str:
    return f"≤ {p:.3f}" if p <= 0.002 else f"= {p:.2g}"


def _lag(pair: str, lag: Any, period: float) -> str:
    a, b = pair.split("→")
    loose = "; loosely coupled" if lag.coherence < 0.5 else ""
    share = f"{lag.share:.2f} of a period ({lag.low:.2f} to {lag.high:.2f}), about {lag.share * period:,.0f} ticks"
    return f"{b} follows {a} by {share}; coherence {lag.coherence:.2f}{loose}."


def _deaths(series: Series) -> str:
    rows = []
    for i, s in enumerate(series.species):
        counts = {c: series.columns[DIED + c][:, i].sum() for c in series.causes}
        total = sum(counts.values())
        rows += [[s, c, f"{k:,.0f}", f"{k / total:.1%}"] for c, k in sorted(counts.items(), key=lambda x: -x[1]) if k]
    return table(["species", "cause", "deaths", "share"], rows) if rows else "<p>Nobody died.</p>"


def ledger_gap(series: Series) -> dict[str, tuple[float, float, int]]:
    """Largest gap of each species' energy ledger: absolute, as a share of the stock, and its tick.

    The ledger of a tick is stock_after = stock_before + endowed + taken_in − burnt − given − lost; the stock that a
    tick starts with must be the one that the tick before ended with.
    """
    c = series.columns
    gap = np.abs(
        c["stock_before"] + c["endowed"] + c["taken_in"] - c["burnt"] - c["given"] - c["lost"] - c["stock_after"]
    )
    gap[1:] = np.maximum(gap[1:], np.abs(c["stock_before"][1:] - c["stock_after"][:-1]))
    worst = gap.argmax(0)
    scale = np.maximum(np.abs(c["stock_after"]).max(0), 1.0)
    return {
        s: (float(gap[worst[i], i]), float(gap[worst[i], i] / scale[i]), int(series.ticks[worst[i]]))
        for i, s in enumerate(series.species)
    }


def _energy(series: Series) -> str:
    flows = ["endowed", "taken_in", "burnt", "given", "lost"]
    if not len(series.ticks) or any(c not in series.columns for c in ("stock_before", "stock_after", *flows)):
        return "<p>The run has no energy ledger.</p>"
    gaps = ledger_gap(series)
    worst = max(gaps, key=lambda s: gaps[s][1])
    gap, share, tick = gaps[worst]
    kept = "closes" if share < 1e-5 else "DOES NOT CLOSE"
    rows = [
        [s, *(number(series.columns[c][:, i].sum()) for c in flows), f"{gaps[s][0]:.2g}"]
        for i, s in enumerate(series.species)
    ]
    text = f"<p>The ledger {kept}: the largest gap in any tick is {gap:.2g}, {share:.1e} of the stock ({escape(worst)}, tick {tick:,}).</p>"
    return text + table(["species", "endowed", "taken in", "burnt", "given", "lost with the dead", "largest gap"], rows)


def rerun(m: Mapping[str, Any]) -> str:
    """The command that runs a world like this from its manifest; changes made with --set are not in it."""
    words = ["ecs-eco run", m.get("world", "WORLD"), f"--seed {m.get('seed', 0)} --ticks {m.get('ticks', 0)}"]
    if m.get("policies", "trained") != "trained":
        words.append(f"--policies {m['policies']}")
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
    return f"<pre>{escape(command)}</pre>{table(['', ''], rows)}<details><summary>All settings</summary><pre>{config}</pre></details>"
