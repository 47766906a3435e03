"""Compare the periods, amplitudes and lags of a run with those of an outside series, all by `signature.cycle`, and
write the report section that shows them. There is no test, because field counts are often too short for those in
`ecs_eco.analysis.spectrum`."""

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecs_eco.analysis.page import drawn, number, table
from ecs_eco.analysis.palette import AXIS
from ecs_eco.analysis.runs import Series, mean_of_there
from ecs_eco.analysis.signature import cycle, spectrum
from ecs_eco.analysis.spectrum import thin
from ecs_eco.analysis.style import PALETTE, Figure, colors_of, panels, styled
from ecs_eco.config.measurements import FEWEST, MOST_ROWS, Outside, outside_of
from ecs_eco.engine.errors import ConfigError, Problem

KEPT = "data.csv"  # the world's outside series, as stored in a run folder


class Summary(NamedTuple):
    """Summary statistics of one series."""

    samples: int
    period: float  # period of the wave that explains the most variance [time unit of the series]
    cycles: float  # number of periods in the series
    share: float  # fraction of the variance that this wave explains
    amplitude: float  # standard deviation of log10 values after removing the trend


class Both(NamedTuple):
    """Summaries of each series in the run [ticks] and in the outside data, and the lags between them."""

    run: dict[str, Summary]
    outside: dict[str, Summary]
    lags: dict[tuple[str, str], tuple[float, float]]  # lag of b behind a in periods, as (run, outside)


def numbers_of(series: Series, name: str) -> np.ndarray:
    """Return the population sizes of a species, or a reporter's values averaged over species: f64[ticks]."""
    if name in series.species:
        return series.of(name)
    return mean_of_there(series.columns[name], axis=1)


def compare(series: Series, outside: Outside, skip: float = 0.1) -> Both:
    """Describe the outside series and the `living` part of the run; raise ConfigError if that is too short."""
    names = list(outside.columns)
    n = living(series, names, skip)
    thinned, factor = thin(n.T, MOST_ROWS)
    ours = dict(zip(names, thinned, strict=True))
    lags = {}
    for a, b in combinations(names, 2):
        both = cycle(ours[a], ours[b]), cycle(outside.columns[a], outside.columns[b])
        lags[a, b] = float(both[0].phases[1]), float(both[1].phases[1])
    run = {name: summary(x, factor)._replace(samples=len(n)) for name, x in ours.items()}
    return Both(run, {name: summary(x, outside.step) for name, x in outside.columns.items()}, lags)


def living(series: Series, names: Sequence[str], skip: float = 0.1) -> np.ndarray:
    """Return values before the first extinction, without the first `skip` of the run: f64[ticks, names]. Raises
    ConfigError if too few ticks remain."""
    n = np.stack([numbers_of(series, name) for name in names], 1)
    species = [name in series.species for name in names]
    gone = np.flatnonzero((n[:, species] == 0).any(1))
    end = int(gone[0]) if gone.size else len(n)
    n = n[min(int(skip * len(n)), end) : end]
    usable = np.isfinite(n).all(0) & (n >= 0).all(0) & n.any(0)
    wrong = [name for name, fine in zip(names, usable, strict=True) if not fine]
    if len(n) >= FEWEST and wrong:
        fault = "is negative or not a number in some ticks, or always 0"
        raise ConfigError([Problem((), fault, wrong[0], "a reporter of counts or densities", source="DIR")])
    if len(n) < FEWEST:
        fault = f"{len(n)} ticks remain before the first extinction"
        raise ConfigError([Problem((), fault, "", "a run in which all species persist", source="DIR")])
    return n


def summary(x: np.ndarray, step: float) -> Summary:
    """Describe one series whose samples are `step` apart. Raises the same errors as `signature.logarithms`."""
    found = cycle(x)
    return Summary(
        len(x), found.period * step, len(x) / found.period, float(found.shares[0]), float(found.swings[0])
    )


def of_run(run: Path, series: Series) -> Outside | None:
    """Return the outside series stored in a run folder, or None if there is none."""
    data = (series.manifest.get("config") or {}).get("data")
    if not data or not (run / KEPT).is_file():
        return None
    return outside_of(
        {**data, "file": KEPT}, run, [*series.species, *series.reporters], str(run / "manifest.json")
    )


def blocks(series: Series, outside: Outside | None, place: Path) -> list[str]:
    """Return the section (empty without an outside series), and write its figure to `place`."""
    if outside is None:
        return []
    both, rows = compare(series, outside), []
    unit, ticks = (outside.unit, outside.ticks) if outside.ticks else ("ticks", 1)
    for name, other in outside.named.items():
        label = name if other == name else f"{name} ({other})"
        for where, s, per, of in (
            ("this run", both.run[name], ticks, unit),
            ("outside", both.outside[name], 1, outside.unit),
        ):
            period, share = f"{number(s.period / per)} {of}", f"{number(100 * s.share)}%"
            rows.append(
                [label, where, f"{s.samples:,}", period, number(s.cycles), share, number(s.amplitude)]
            )
    lags = [
        [f"{b} behind {a}", *(f"{number(share)} of a period" for share in shares)]
        for (a, b), shares in both.lags.items()
    ]
    head = ["", "", "samples", "period", "cycles", "variance explained", "amplitude [log10]"]
    return [
        "<h2>Comparison with the outside series</h2>",
        _NOTE,
        table(head, rows),
        *([table(["", "this run", "outside"], lags)] if lags else []),
        drawn(figure(series, outside, both), place / "figures" / "against.svg", _CAPTION),
    ]


_NOTE = (
    "<p>Both series are described by the wave that explains the most variance of their detrended log "
    "numbers. This is a description, not a test; for a test of the run, see Cycles.</p>"
)
_CAPTION = (
    "Numbers over time on the same scale (top), and the fraction of the variance that a wave of each period "
    "explains (bottom), for this run (left) and the outside series (right). On each side, the unit of time "
    "is the period of the first column."
)


@styled
def figure(series: Series, outside: Outside, both: Both) -> Figure:
    """Plot values over time and spectra, with the run on the left and the outside series on the right."""
    hue = colors_of(series)
    hue |= {name: PALETTE[-1 - i % 3] for i, name in enumerate(outside.columns) if name not in hue}
    chart, axes = panels(2, 2, 9, 5.2, sharey="row")
    first = next(iter(outside.columns))
    end = min(both.run[first].cycles, max(2 * both.outside[first].cycles, 6.0))
    alive = dict(zip(outside.columns, living(series, list(outside.columns)).T, strict=True))
    for k, held in enumerate(({name: numbers_of(series, name) for name in outside.columns}, outside.columns)):
        described = (both.run, both.outside)[k]
        period = described[first].period / (outside.step if k else 1.0)
        for name, x in held.items():
            least = np.min(x[x > 0], initial=np.inf) / 2  # zeros count as half the smallest positive number
            logs = np.log10(np.maximum(x, least))
            time = np.arange(len(x)) / period
            shown = time <= end if k == 0 else np.ones(len(x), bool)
            axes[0, k].plot(time[shown], (logs - np.nanmean(logs))[shown], color=hue[name], label=name)
            samples, factor = (x, 1) if k else thin(alive[name], MOST_ROWS)
            frequency, share = spectrum(samples)
            axes[1, k].plot(factor / frequency / period, share, color=hue[name])
        axes[0, k].set(title="outside" if k else "this run", xlabel=f"time [periods of {first}]")
        axes[1, k].set(xlim=(0.2, 4), xlabel=f"period [of {first}]")
        axes[1, k].axvline(1, color=AXIS, lw=0.8)
    axes[0, 0].set_ylabel("log10 number, minus its mean")
    axes[1, 0].set_ylabel("fraction of the variance")
    axes[0, 0].legend(loc="upper left", ncols=3)
    return chart
