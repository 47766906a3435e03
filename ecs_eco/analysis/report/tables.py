"""The tables and sentences of a report, as HTML, and what they need of a run folder besides its series."""

from collections.abc import Mapping
from html import escape
from pathlib import Path

import numpy as np

from ecs_eco.analysis import figures
from ecs_eco.analysis.cycles import CycleStatistics, Lag
from ecs_eco.analysis.page import Markup, number, table
from ecs_eco.analysis.palette import ON_DARK
from ecs_eco.analysis.runs import DIED, Series, parts
from ecs_eco.analysis.spectrum import Peak
from ecs_eco.analysis.style import colors_of
from ecs_eco.record import seal
from ecs_eco.record.ledger import LEDGER, imbalance
from ecs_eco.record.parquet import each_batch, read_part, to_codes, to_numpy

FEW_PERIODS = 5
"""Below so many periods in a run the report asks for a longer one."""


def interventions(series: Series) -> str:
    """A table of interventions, with one row for a repeated one; "" without any."""
    ticks: dict[str, list[int]] = {}
    for tick, text in figures.interventions(series):
        ticks.setdefault(text, []).append(tick)
    when = {text: f"{at[0]:,}" if len(at) == 1 else f"{at[0]:,} to {at[-1]:,}" for text, at in ticks.items()}
    rows = [[when[text], f"{len(at):,}", text] for text, at in ticks.items()]
    return table(["tick", "times", "what"], rows) if rows else ""


def numbers(series: Series, ages: Mapping[str, tuple[int, float]]) -> str:
    """A row per species: its numbers, births, deaths and how long it lived;
    `ages` holds deaths and mean age at death."""
    if not len(series.ticks):
        return "<p>The run has no ticks.</p>"
    head = [
        "species",
        "first tick",
        "mean",
        "least",
        "most",
        "last tick",
        "births",
        "refused",
        "deaths",
        "mean age at death [s]",
        "life expectancy [s]",
    ]
    note = (
        "Refused are births for which max_count left no room. Life expectancy is the total time lived "
        "divided by deaths: unlike the age at death, it counts those still alive."
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
    """Which species cycle, with what period, and which follows which."""
    if not statistics.enough:
        return (
            "<p>The run is too short to look for cycles: "
            f"{statistics.ticks:,} ticks are left after the first tenth and before the first extinction. "
            "Ten periods or more are needed, in practice thousands of ticks.</p>"
        )
    cycling = statistics.cycling()
    items = "".join(
        f"<li>{escape(_cycle(s, statistics.peaks[s], s in cycling))}</li>" for s in statistics.species
    )
    method = (
        "<p class='under'>p is the chance of so high a spectral peak, at any of the periods tested, "
        f"in a population that drifts and relaxes without cycling ({statistics.ticks:,} ticks, "
        "without the first tenth). One run is one replicate: <code>ecs-eco compare</code> pools seeds.</p>"
    )
    if not cycling or not statistics.period:
        return f"<ul>{items}</ul>{method}"
    lags = "".join(
        f"<li>{escape(_lag(pair, x, statistics.period))}</li>" for pair, x in statistics.lags.items()
    )
    who = (
        f"<p>Which species follows which, at the period of {statistics.period:,.0f} ticks (95 % "
        "intervals):</p>"
    )
    return f"<ul>{items}</ul>{who}<ul>{lags}</ul>{method}"


def _cycle(species: str, peak: Peak | None, cycles: bool) -> str:
    if peak is None:
        return f"{species}: its number does not change."
    if not cycles and peak.p <= 0.05:
        why = (
            f"slower swings have {peak.slower:,.1f} times its variance"
            if peak.slower > 1
            else f"the series holds it {peak.held:,.1f} times only"
        )
        return (
            f"{species}: no cycle; of the bump of its spectrum at {peak.period:,.0f} ticks "
            f"(p {_p(peak.p)}), {why}."
        )
    if not cycles:
        return f"{species}: no cycle beyond red noise (p {_p(peak.p)})."
    few = (
        f" Fewer than {FEW_PERIODS} periods: a longer run is needed to be sure."
        if peak.n_periods < FEW_PERIODS
        else ""
    )
    return (
        f"{species} cycles: a period of {peak.period:,.0f} ticks, {peak.n_periods:.1f} periods, "
        f"p {_p(peak.p)}.{few}"
    )


def _p(p: float) -> str:
    return f"≤ {p:.3f}" if p <= 0.002 else f"= {p:.2g}"


def _lag(pair: str, lag: Lag, period: float) -> str:
    a, b = pair.split("→")
    loose = "; loosely coupled" if lag.coherence < 0.5 else ""
    share = (
        f"{lag.share:.2f} of a period ({lag.low:.2f} to {lag.high:.2f}), "
        f"about {lag.share * period:,.0f} ticks"
    )
    return f"{b} follows {a} by {share}; coherence {lag.coherence:.2f}{loose}."


def deaths(series: Series) -> str:
    """A row per species and cause of death."""
    rows = []
    for i, s in enumerate(series.species):
        counts = {c: series.columns[DIED + c][:, i].sum() for c in series.causes}
        total = sum(counts.values())
        rows += [
            [s, c, f"{k:,.0f}", f"{k / total:.1%}"]
            for c, k in sorted(counts.items(), key=lambda x: -x[1])
            if k
        ]
    return table(["species", "cause", "deaths", "share"], rows) if rows else "<p>Nobody died.</p>"


def energy(series: Series) -> str:
    """Whether the energy ledger closes, and the sums of its flows by species."""
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
    head = ["species", "endowed", "taken in", "burnt", "given", "lost with the dead", "largest gap"]
    return f"<p>The ledger {kept}: the largest gap in any tick is {gap:.2g}, {where}.</p>{table(head, rows)}"


def ages_at_death(run: Path | str) -> dict[str, tuple[int, float]]:
    """Deaths and mean age at death [s] of each species, streamed from deaths/*.parquet."""
    totals: dict[str, np.ndarray] = {}
    sealed = seal.has_seals(Path(run))
    for file in parts(run, "deaths"):
        for batch in each_batch(file, ["species", "age"], sealed):
            names, code = to_codes(batch["species"])
            age = to_numpy(batch["age"])
            for i, s in enumerate(names):
                here = age[code == i]
                totals[s] = totals.get(s, np.zeros(2)) + (len(here), here.sum(dtype=np.float64))
    return {s: (int(n), float(total / n) if n else np.nan) for s, (n, total) in totals.items()}


def last_snapshot(run: Path | str, species: tuple[str, ...]) -> tuple[int, dict[str, np.ndarray]] | None:
    """Tick and positions (n, 3) [m] by species of the last snapshot; None where there is none."""
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
    """Largest gap of each species' energy ledger: absolute, as a share of the stock, and its tick.

    The stock that a tick starts with must be the one that the tick before ended with.
    """
    c = series.columns
    gap: np.ndarray = np.abs(imbalance(c))
    gap[1:] = np.maximum(gap[1:], np.abs(c["stock_before"][1:] - c["stock_after"][:-1]))
    worst = gap.argmax(0)
    scale = np.maximum(np.abs(c["stock_after"]).max(0), 1.0)
    return {
        s: (float(gap[worst[i], i]), float(gap[worst[i], i] / scale[i]), int(series.ticks[worst[i]]))
        for i, s in enumerate(series.species)
    }
