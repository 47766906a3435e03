"""The report section that compares the run with an outside series."""

from pathlib import Path

import numpy as np

from ecs_eco.analysis.against import Both, compare, living, numbers_of
from ecs_eco.analysis.page import drawn, number, table
from ecs_eco.analysis.palette import AXIS
from ecs_eco.analysis.runs import Series
from ecs_eco.analysis.signature import spectrum
from ecs_eco.analysis.spectrum import thin
from ecs_eco.analysis.style import PALETTE, Figure, colors_of, panels, styled
from ecs_eco.config.measurements import MOST_ROWS, Outside, outside_of
from ecs_eco.record.claim import DATA


def of_run(run: Path, series: Series) -> Outside | None:
    """Return the outside series stored in a run folder, or None if there is none."""
    data = (series.manifest.get("config") or {}).get("data")
    if not data or not (run / DATA).is_file():
        return None
    return outside_of(
        {**data, "file": DATA}, run, [*series.species, *series.reporters], str(run / "manifest.json")
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
