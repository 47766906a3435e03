"""The figures of a report, each written beside it and embedded in it."""

from collections.abc import Iterator
from pathlib import Path

from ecs_eco.analysis import figures, measures, page
from ecs_eco.analysis.cycles import CycleStatistics
from ecs_eco.analysis.land import land_at
from ecs_eco.analysis.relief import Relief
from ecs_eco.analysis.report.tables import last_snapshot
from ecs_eco.analysis.runs import DIED, Series
from ecs_eco.analysis.style import Figure, colors_of

Drawn = tuple[str, Figure, str]  # name of the file, figure, caption


def draw(run: Path, series: Series, cycles: CycleStatistics, place: Path) -> dict[str, str]:
    """The figures for which this run has data, as HTML by name; they are written below `place`."""
    if not len(series.ticks) or not len(series.species):
        return {}
    drawn = [*_numbers(series), *_cycles(series, cycles), *_flows(series), *_places(run, series)]
    return {name: page.drawn(f, place / "figures" / f"{name}.svg", caption) for name, f, caption in drawn}


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
