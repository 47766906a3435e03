"""Figures of evolving genes: allele frequencies and quantitative genes, of a run and of arms side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.analysis.carriers import Frequencies, lines_of
from ecs_eco.analysis.genes import Course
from ecs_eco.analysis.palette import GREY, INK
from ecs_eco.analysis.style import DASHES, PALETTE, panels, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Band(NamedTuple):
    """A mean over runs with its 95 % interval at ticks, f64[samples] each."""

    ticks: np.ndarray
    mean: np.ndarray
    low: np.ndarray
    high: np.ndarray


@styled
def alleles(genes: Sequence[Frequencies], title: str = "") -> Figure:
    """Allele frequencies over time: of genes with two values that of the second, of others all."""
    figure, ((ax,),) = panels(1, 1, 9, 3.4)
    lines = lines_of(genes, all_values=True)
    for g, j, label, hue, dash in lines:
        of = label if len(g.values) > 2 else f"{label} = {g.values[j]}"
        ax.plot(g.ticks, g.allele[:, j], color=hue, ls=dash, lw=1.7, label=of)
    ax.set(xlabel="tick", ylabel="allele frequency", ylim=(-0.02, 1.02), title=title)
    if genes:
        ax.set_xlim(genes[0].ticks[0], max(genes[0].ticks[-1], 1))
    figure.legend(loc="outside upper left", ncols=min(max(len(lines), 1), 5))
    return figure


@styled
def courses(genes: Sequence[Course], traits: Mapping[str, str | None], hue: str, title: str = "") -> Figure:
    """Quantitative genes over time: shade is the share of the living with a value, the line the mean, dashes
    one standard deviation about it."""
    from matplotlib.colors import LinearSegmentedColormap

    figure, axes = panels(len(genes), 1, 9, 2.3 * len(genes) + 0.7, sharex=True)
    shades = LinearSegmentedColormap.from_list("share", [GREY + "00", GREY])
    for k, (ax, g) in enumerate(zip(axes[:, 0], genes, strict=True)):
        half = np.diff(g.ticks)[0] / 2 if len(g.ticks) > 1 else 0.5
        sides, share = np.append(g.ticks - half, g.ticks[-1] + half), np.nan_to_num(g.share.T)
        top = max(float(share.max(initial=0.0)), 1e-9)
        mesh = ax.pcolormesh(sides, g.edges, share, cmap=shades, norm=_root(top), rasterized=True)
        ax.plot(g.ticks, g.mean, color=INK, lw=1.6, label="mean")
        for sign in (-1, 1):
            ax.plot(
                g.ticks,
                g.mean + sign * g.sd,
                color=INK,
                lw=0.9,
                ls=(0, (4, 2)),
                label="± 1 standard deviation" if sign > 0 else None,
            )
        ax.set(
            title=f"{title}: {g.gene}" if title else g.gene,
            xlim=(g.ticks[0], max(g.ticks[-1], 1)),
            ylabel=traits.get(g.gene) or g.gene,
        )
        ax.grid(visible=False)
        bar = figure.colorbar(mesh, ax=ax, pad=0.01, aspect=12, format=lambda x, _: f"{100 * x:.2g} %")
        bar.set_label("share of the living", fontsize=8.5)
        bar.set_ticks([0, top / 4, top])
        if k == 0:
            figure.legend(*ax.get_legend_handles_labels(), loc="outside upper left", ncols=2)
    axes[-1, 0].set_xlabel("tick")
    return figure


def _root(top: float) -> Any:
    """Shades by the square root of shares, so that the rare are seen beside the common."""
    from matplotlib.colors import PowerNorm

    return PowerNorm(0.5, vmin=0.0, vmax=top)


@styled
def arms(
    bands: Mapping[str, Mapping[str, Band]], labels: Mapping[str, str], title: str = "", shares: bool = True
) -> Figure:
    """A panel for each gene (gene → arm → Band): the mean over runs of each arm, with its 95 % band.

    `labels` are the words at each panel's vertical axis, by gene; `shares` lie from 0 to 1.
    """
    columns = min(2, len(bands))
    rows = -(-len(bands) // columns)
    figure, axes = panels(rows, columns, 4.6 * columns + 0.6, 2.5 * rows + 0.8, sharex=True)
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
    for ax in axes.flat[len(bands) :]:
        ax.set_axis_off()
    for ax in axes[-1]:
        ax.set_xlabel("tick")
    if title:
        figure.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=11)
    handles, names = axes.flat[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper left", ncols=min(len(names), 5))
    return figure
