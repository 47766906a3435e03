"""The matter ledger of a recorded run: stocks of each substance over time, and its flows."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa

from ecs_eco.analysis.learning import thinned
from ecs_eco.analysis.page import bullets, drawn, number, table
from ecs_eco.analysis.runs import Series, pivot, whole_table
from ecs_eco.analysis.style import PALETTE, Figure, colors_of, over_ticks, styled

WITHIN = ("eaten", "taken_up", "released", "emitted", "remains")
"""Flows between holders; all other flows enter, leave, or are reactions."""
SURE = 1e-5  # largest gap in a ledger that closes, as a fraction of the greatest stock


@dataclass(frozen=True)
class Ledger:
    """The ledger: `columns[flow]` [mol], f64[ticks, holders, substances], and `stock_before` and `stock_after`."""

    ticks: np.ndarray
    holders: tuple[str, ...]
    substances: tuple[str, ...]
    columns: dict[str, np.ndarray]

    @property
    def flows(self) -> tuple[str, ...]:
        """Names of the flows, which are positive if they enter the holder."""
        return tuple(name for name in self.columns if not name.startswith("stock_"))

    @property
    def stock(self) -> np.ndarray:
        """The stock of each holder at the end of each tick, f64[ticks, holders, substances] [mol]."""
        return self.columns["stock_after"]

    def gap(self) -> tuple[float, float, int]:
        """Return the gap [mol] that is the largest fraction of the greatest stock, that fraction, and the tick."""
        c = self.columns
        gap = np.abs(c["stock_before"] + sum(c[f] for f in self.flows) - self.stock)
        gap[1:] = np.maximum(gap[1:], np.abs(c["stock_before"][1:] - self.stock[:-1]))
        scale = np.maximum(np.abs(self.stock).sum(axis=1).max(axis=0), 1e-300)
        share = gap / scale
        at = np.unravel_index(int(share.argmax()), share.shape)
        return float(gap[at]), float(share[at]), int(self.ticks[at[0]])


def ledger_of(table: pa.Table) -> Ledger:
    """Return the ledger from a table of `world.recorder.matter_series()`."""
    ticks, (holders, substances), columns = pivot(table, "holder", "substance")
    return Ledger(ticks, holders, substances, columns)


def read(run: Path | str) -> Ledger | None:
    """Return the matter ledger of a run folder, or None if it has none."""
    table = whole_table(run, "matter")
    return ledger_of(table) if len(table) else None


def told(ledger: Ledger) -> list[str]:
    """Return a sentence on the fate of each substance, and one on whether the ledger closes."""
    lines = []
    for k, name in enumerate(ledger.substances):
        before, after = ledger.columns["stock_before"][0, :, k].sum(), ledger.stock[-1, :, k].sum()
        flows = {f: float(ledger.columns[f][:, :, k].sum()) for f in ledger.flows if f not in WITHIN}
        large = {f: v for f, v in flows.items() if abs(v) > SURE * max(before, after, 1e-300)}
        ranked = sorted(large.items(), key=lambda x: -abs(x[1]))
        some = ", ".join(f"{f.replace('_', ' ')} {'+' if v > 0 else ''}{number(v)}" for f, v in ranked)
        most = int(ledger.stock[-1, :, k].argmax())
        share = ledger.stock[-1, most, k] / after if after > 0 else 0.0
        end = f"; the largest share, {share:.0%}, is in {ledger.holders[most]}" if share > 0 else ""
        what = f" ({some})" if some else ", no inflow or outflow"
        lines.append(f"{name}: {number(before)} mol at the start, {number(after)} mol at the end{what}{end}.")
    gap, share, tick = ledger.gap()
    kept = "closes" if share < SURE else "DOES NOT CLOSE"
    worst = f"the largest gap in any tick is {gap:.2g} mol, {share:.1e} of the stock (tick {tick:,})"
    return [*lines, f"The matter ledger {kept}: {worst}."]


@styled
def stocks(ledger: Ledger, hue: Mapping[str, str]) -> Figure:
    """Plot stacked stocks over time, with a row for each substance; only species are not hatched."""
    figure, axes = over_ticks(len(ledger.substances), 2.1, 0.7)
    others = [h for h in ledger.holders if h not in hue]
    for k, (ax, name) in enumerate(zip(axes, ledger.substances, strict=True)):
        for_all = [thinned(ledger.ticks, ledger.stock[:, i, k], 400) for i in range(len(ledger.holders))]
        shades = [hue.get(h) or PALETTE[(others.index(h) + 3) % len(PALETTE)] for h in ledger.holders]
        areas = ax.stackplot(
            for_all[0][0], [np.maximum(v, 0) for _, v in for_all], colors=shades, lw=0, labels=ledger.holders
        )
        for area, holder in zip(areas, ledger.holders, strict=True):
            if holder in others:
                area.set(hatch="//", edgecolor="white", linewidth=0)
        ax.set(title=name, ylabel="stock [mol]", ylim=(0, None))
        ax.margins(x=0)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper left", ncols=5)
    return figure


def blocks(run: Path, series: Series, place: Path) -> list[str]:
    """Return the section on matter (empty without substances), and write its figure to `place`."""
    ledger = read(run)
    if ledger is None:
        return []
    caption = "Stocks of each substance over time, by species, kind of object and field."
    return [
        "<h2>Matter</h2>",
        bullets(told(ledger)),
        drawn(stocks(ledger, colors_of(series)), place / "figures" / "matter.svg", caption),
        sums(ledger),
    ]


def sums(ledger: Ledger) -> str:
    """Return a table of total flows [mol] by substance and holder."""
    total = {f: ledger.columns[f].sum(axis=0) for f in ledger.flows}
    shown = [f for f in ledger.flows if total[f].any()]
    rows = []
    for k, name in enumerate(ledger.substances):
        for i, holder in enumerate(ledger.holders):
            sums = [total[f][i, k] for f in shown]
            ends = ledger.columns["stock_before"][0, i, k], ledger.stock[-1, i, k]
            if ledger.stock[:, i, k].any() or any(sums):
                rows.append([name, holder, *map(number, (ends[0], *sums, ends[1]))])
    head = ["substance", "in", "start [mol]", *(f.replace("_", " ") for f in shown), "end [mol]"]
    return table(head, rows)
