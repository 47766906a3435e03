"""The figures of a report, each written beside it and embedded in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ecs_eco.analysis import figures
from ecs_eco.analysis.carriers import carriers, has_few_values
from ecs_eco.analysis.cycles import CycleStatistics
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.page import picture
from ecs_eco.analysis.report.recorded import last_snapshot
from ecs_eco.analysis.runs import DIED, Series

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    Drawn = tuple[str, Figure, str]  # name of the file, figure, caption


def draw(run: Path, series: Series, cycles: CycleStatistics, place: Path) -> dict[str, str]:
    """The figures for which this run has data, as HTML by name; they are written below `place`."""
    if not len(series.ticks) or not len(series.species):
        return {}
    drawn = [*_numbers(series), *_cycles(series, cycles), *_flows(series), *_genes(run, series),
             *_places(run, series)]
    return {name: picture(figures.save(f, place / "figures" / f"{name}.png"), caption)
            for name, f, caption in drawn}


def _numbers(series: Series) -> Iterator[Drawn]:
    marked = "; a dashed line marks an intervention" if figures.interventions(series) else ""
    yield ("populations", figures.populations(series),
           f"Numbers over time. A cross marks the end of a species{marked}.")


def _cycles(series: Series, cycles: CycleStatistics) -> Iterator[Drawn]:
    hue = figures.colors(series.species, series.manifest.get("colors"))
    present = [s for s, here in zip(series.species, series.present, strict=True) if here]
    pairs = list(zip(present, present[1:], strict=False))
    peaks = {s: peak for s, peak in cycles.peaks.items() if peak is not None}
    if peaks:
        band = "the band is that of a population that drifts without cycling"
        yield ("spectra", figures.spectra(peaks, hue),
               f"Spectra. A cycle is a peak above the grey band; {band}.")
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


def _genes(run: Path, series: Series) -> Iterator[Drawn]:
    for s, genes in genes_shown(series.manifest).items():
        lineage = Lineage.read(run)
        if s not in lineage.species:
            continue
        every = max(1, len(series.ticks) // 500)
        counts = [lineage.frequencies(s, gene, every) for gene in genes]
        without = ("An organism with the value of a gene's first codon counts as without that gene; "
                   "the grey line counts all")
        yield (f"carriers-{series.index(s)}", carriers(counts, s),
               f"Number of {s} that carry each gene. {without}.")


def _places(run: Path, series: Series) -> Iterator[Drawn]:
    size = series.manifest.get("config", {}).get("space", {}).get("size")
    snapshot = last_snapshot(run, series.species) if size else None
    if size and snapshot:
        hue = figures.colors(series.species, series.manifest.get("colors"))
        yield ("positions", figures.positions(snapshot[1], size, hue),
               f"All organisms at tick {snapshot[0]:,}.")


def genes_shown(manifest: Mapping[str, Any]) -> dict[str, list[str]]:
    """The genes of each species that have few enough values for a figure."""
    genomes = manifest.get("genomes", {})
    by_species = {s: [g["name"] for g in genome["genes"] if has_few_values(g)]
                  for s, genome in genomes.items()}
    return {s: names for s, names in by_species.items() if names}
