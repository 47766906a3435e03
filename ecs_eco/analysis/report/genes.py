"""The part of a report on species with genomes: which alleles spread, and how quantitative genes change."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.analysis import figures, genes_figures
from ecs_eco.analysis.carriers import carriers
from ecs_eco.analysis.genes import (
    SAMPLES,
    course,
    few_valued,
    generation_time,
    haldanes,
    quantitative,
    selection_of,
)
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.page import number, picture, table
from ecs_eco.analysis.runs import Series

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANELS = 8  # of one figure


def blocks(run: Path, series: Series, place: Path) -> list[str]:
    """Figures and tables of the genes of each species; nothing where no genome was recorded, or nobody had
    one.

    Figures are written below `place`.
    """
    genomes = {
        s: kept
        for s, kept in series.manifest.get("genomes", {}).items()
        if few_valued(kept) or quantitative(kept)
    }
    if not genomes or not len(series.ticks):
        return []
    lineage = Lineage.read(run)
    parts = [part for s in genomes if s in lineage.species for part in _species(lineage, series, s, place)]
    return ["<h2>Genes</h2>", *parts] if parts else []


def _species(lineage: Lineage, series: Series, s: str, place: Path) -> Iterator[str]:
    kept, i = lineage.genomes[s], series.index(s)
    every = max(1, len(series.ticks) // SAMPLES)
    generation = generation_time(lineage, s)
    if few := few_valued(kept):
        counts = [lineage.frequencies(s, gene, every) for gene in few]
        without = (
            "An organism with the value of a gene's first codon counts as without that gene; "
            "the grey line counts all"
        )
        yield _drawn(
            place, f"carriers-{i}", carriers(counts, s), f"Number of {s} that carry each gene. {without}."
        )
        yield _drawn(
            place,
            f"alleles-{i}",
            genes_figures.alleles(counts, s),
            f"Allele frequencies of {s}: the share of each value among all copies of a gene.",
        )
        yield _selection(counts, generation)
    if many := quantitative(kept):
        hue = figures.colors(series.species, series.manifest.get("colors"))[s]
        found = [course(lineage, s, gene, every) for gene in many]
        traits = {g["name"]: g["trait"] for g in (*kept["genes"], *kept.get("derived", []))}
        for k in range(0, len(found), PANELS):
            drawn = genes_figures.courses(found[k : k + PANELS], traits, hue, s)
            yield _drawn(
                place,
                f"genes-{i}" + (f"-{k // PANELS}" if k else ""),
                drawn,
                f"Genes of {s} that say a number: the share of the living with each value, and their mean.",
            )
        yield _change(found, traits, generation)


def _drawn(place: Path, name: str, figure: Figure, caption: str) -> str:
    return picture(figures.save_svg(figure, place / "figures" / f"{name}.svg"), caption)


def _selection(counts: list[Any], generation: float) -> str:
    rows = []
    for g in counts:
        for j in range(1 if len(g.values) == 2 else 0, len(g.values)):
            found = selection_of(g.allele[:, j], g.ticks, g.copies.sum(axis=1), generation)
            rows.append(
                [
                    g.gene,
                    g.values[j],
                    number(found.first),
                    number(found.last),
                    number(found.s),
                    number(1000 * found.per_tick),
                ]
            )
    head = ["gene", "value", "frequency at first", "at last", "s per generation", "s per 1,000 ticks"]
    note = (
        "s is the slope of the log odds of a value against all others, mutation and chance included: "
        f"a neutral gene shows how large these are. A generation is {_ticks(generation)}, the mean age "
        "of parents at the birth of their offspring. One run is one replicate: "
        "<code>ecs-eco compare</code> gives intervals over seeds."
    )
    return f"{table(head, rows)}<p class='under'>{note}</p>"


def _change(found: list[Any], traits: dict[str, str | None], generation: float) -> str:
    rows = []
    for c in found:
        there = np.flatnonzero(c.n)
        ends = [(c.mean[k], c.sd[k]) for k in (there[0], there[-1])] if there.size else [(np.nan, np.nan)] * 2
        rows.append(
            [
                c.gene,
                traits[c.gene] or "–",
                *(f"{number(m)} ± {number(sd)}" for m, sd in ends),
                number(haldanes(c, generation)),
            ]
        )
    head = ["gene", "trait", "mean ± standard deviation at first", "at last", "change per generation [sd]"]
    note = (
        f"Change is the slope of the mean, in standard deviations per generation of {_ticks(generation)} "
        "(haldanes)."
    )
    return f"{table(head, rows)}<p class='under'>{note}</p>"


def _ticks(generation: float) -> str:
    return "not known, as nobody was born of parents" if np.isnan(generation) else f"{generation:,.0f} ticks"
