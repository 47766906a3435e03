"""Figures and report sections on evolving genes: allele frequencies and quantitative genes of runs and arms."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecs_eco.analysis.carriers import Frequencies, carriers, draw_values, genes_in
from ecs_eco.analysis.genes import (
    SAMPLES,
    Course,
    course,
    few_valued,
    generation_time,
    haldanes,
    quantitative,
    selections,
)
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.page import drawn, number, table
from ecs_eco.analysis.palette import GREY
from ecs_eco.analysis.runs import Series
from ecs_eco.analysis.style import DASHES, PALETTE, Figure, mean_and_sd, over_ticks, several, styled

PANELS = 8  # of one figure


class Band(NamedTuple):
    """The mean over runs and its 95% interval at the sampled ticks, f64[samples] each."""

    ticks: np.ndarray
    mean: np.ndarray
    low: np.ndarray
    high: np.ndarray


@styled
def alleles(genes: Sequence[Frequencies], title: str = "") -> Figure:
    """Plot allele frequencies over time: the second value of two-valued genes, all values of other genes."""
    figure, ax = draw_values(genes, title, "allele frequency", 3.4, alleles=True)
    ax.set_ylim(-0.02, 1.02)
    figure.legend(loc="outside upper left", ncols=5)
    return figure


@styled
def courses(genes: Sequence[Course], traits: Mapping[str, str | None], title: str = "") -> Figure:
    """Plot quantitative genes over time: their distribution (shades), mean and standard deviation (lines)."""
    from matplotlib.colors import LinearSegmentedColormap, PowerNorm

    figure, axes = over_ticks(len(genes), 2.3, 0.7)
    shades = LinearSegmentedColormap.from_list("share", [GREY + "00", GREY])
    for k, (ax, g) in enumerate(zip(axes, genes, strict=True)):
        half = np.diff(g.ticks)[0] / 2 if len(g.ticks) > 1 else 0.5
        sides, share = np.append(g.ticks - half, g.ticks[-1] + half), np.nan_to_num(g.share.T)
        top = max(float(share.max(initial=0.0)), 1e-9)
        norm = PowerNorm(0.5, vmin=0.0, vmax=top)
        mesh = ax.pcolormesh(sides, g.edges, share, cmap=shades, norm=norm, rasterized=True)
        mean_and_sd(ax, g.ticks, g.mean, g.sd)
        ax.set(xlim=(g.ticks[0], max(g.ticks[-1], 1)), ylabel=traits.get(g.gene) or g.gene)
        ax.set_title(f"{title}: {g.gene}" if title else g.gene)
        ax.grid(visible=False)
        bar = figure.colorbar(mesh, ax=ax, pad=0.01, aspect=12, format=lambda x, _: f"{100 * x:.3g}%")
        bar.set_label("fraction of living organisms", fontsize=9)
        bar.set_ticks([0, top / 4, top])
        if k == 0:
            figure.legend(*ax.get_legend_handles_labels(), loc="outside upper left", ncols=2)
    return figure


@styled
def arms(
    bands: Mapping[str, Mapping[str, Band]], labels: Mapping[str, str], title: str = "", shares: bool = True
) -> Figure:
    """Draw a panel for each gene (gene → arm → Band): the mean over runs of each arm, with its 95% band. `labels`
    are those of vertical axes, by gene; `shares` sets the axes to range from 0 to 1."""
    figure, axes = several(len(bands), 2, (4.6, 2.5), (0.6, 0.8), sharex=True)
    for ax, (gene, by_arm) in zip(axes.flat, bands.items(), strict=False):
        for k, (arm, band) in enumerate(by_arm.items()):
            hue = PALETTE[(k + 2) % len(PALETTE)]
            ax.fill_between(band.ticks, band.low, band.high, color=hue, alpha=0.15, lw=0)
            ax.plot(band.ticks, band.mean, color=hue, ls=DASHES[k % len(DASHES)], lw=1.8, label=arm)
        ax.set(title=gene, ylabel=labels[gene])
        if shares:
            ax.set_ylim(-0.02, 1.02)
        ax.margins(x=0)
        ax.xaxis.set_tick_params(labelbottom=True)
    for ax in axes[-1]:
        ax.set_xlabel("tick")
    if title:
        figure.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=11)
    figure.legend(*axes.flat[0].get_legend_handles_labels(), loc="outside upper left", ncols=5)
    return figure


def blocks(run: Path, series: Series, place: Path) -> list[str]:
    """Return the section on genes, empty if none were recorded, and write its figures to `place`."""
    kept = series.manifest.get("genomes", {})
    having = [s for s in kept if few_valued(kept[s]) or quantitative(kept[s])]
    if not having or not len(series.ticks):
        return []
    lineage = Lineage.read(run)
    parts = [part for s in having if s in lineage.species for part in _species(lineage, series, s, place)]
    return ["<h2>Genes</h2>", *parts] if parts else []


def _species(lineage: Lineage, series: Series, s: str, place: Path) -> Iterator[str]:
    kept, i, folder = lineage.genomes[s], series.index(s), place / "figures"
    every = max(1, len(series.ticks) // SAMPLES)
    generation = generation_time(lineage, s)
    if few := few_valued(kept):
        counts = [lineage.frequencies(s, gene, every) for gene in few]
        text = (
            f"Number of {s} that carry each gene. Organisms with the value of a gene's first codon do not "
            "count as carriers; the gray line counts all organisms."
        )
        yield drawn(carriers(counts, s), folder / f"carriers-{i}.svg", text)
        text = f"Allele frequencies of {s}: the fraction of each value among all copies of a gene."
        yield drawn(alleles(counts, s), folder / f"alleles-{i}.svg", text)
        yield _selection(counts, generation)
    if many := quantitative(kept):
        found = [course(lineage, s, gene, every) for gene in many]
        traits = {g["name"]: g["trait"] for g in genes_in(kept)}
        for k in range(0, len(found), PANELS):
            file = folder / (f"genes-{i}" + (f"-{k // PANELS}" if k else "") + ".svg")
            text = f"Quantitative genes of {s}: the fraction of living organisms with each value, and means."
            yield drawn(courses(found[k : k + PANELS], traits, s), file, text)
        yield _change(found, traits, generation)


def _selection(counts: list[Frequencies], generation: float) -> str:
    rows = []
    for g in counts:
        for value, _, of in selections(g, generation):
            rows.append([g.gene, value, *map(number, (of.first, of.last, of.s, 1000 * of.per_tick))])
    head = ["gene", "value", "first frequency", "last", "s per generation", "s per 1,000 ticks"]
    note = (
        "s is the slope of the log odds of a value against all others. It includes mutation and drift; a "
        "neutral gene shows how large they are. The generation time (the mean age of parents at the birth of "
        f"their offspring) is {_ticks(generation)}. One run is one replicate; <code>ecs-eco compare</code> "
        "computes intervals over seeds."
    )
    return f"{table(head, rows)}<p class='under'>{note}</p>"


def _change(found: list[Course], traits: dict[str, str | None], generation: float) -> str:
    rows = []
    for c in found:
        there = np.flatnonzero(c.n)
        ends = [(c.mean[k], c.sd[k]) for k in (there[0], there[-1])] if there.size else [(np.nan, np.nan)] * 2
        means = (f"{number(m)} ± {number(sd)}" for m, sd in ends)
        rows.append([c.gene, traits[c.gene] or "–", *means, number(haldanes(c, generation))])
    head = ["gene", "trait", "first mean ± standard deviation", "last", "change per generation [sd]"]
    note = (
        "Change is the slope of the mean, in standard deviations per generation (haldanes). The generation "
        f"time is {_ticks(generation)}."
    )
    return f"{table(head, rows)}<p class='under'>{note}</p>"


def _ticks(generation: float) -> str:
    known = not np.isnan(generation)
    return f"{generation:,.0f} ticks" if known else "unknown because no organism was born to parents"
