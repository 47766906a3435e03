"""The part of a report on substances: what holds them, what flowed, and whether the ledger closes."""

from __future__ import annotations

from html import escape
from pathlib import Path

from ecs_eco.analysis import figures, matter
from ecs_eco.analysis.page import number, table
from ecs_eco.analysis.report.learning import drawn
from ecs_eco.analysis.runs import Series


def blocks(run: Path, series: Series, place: Path) -> list[str]:
    """Sentences, the figure of stocks and the sums of flows; nothing where nothing holds a substance.

    The figure is written below `place`.
    """
    ledger = matter.read(run)
    if ledger is None:
        return []
    hue = figures.colors(series.species, series.manifest.get("colors"))
    lines = "".join(f"<li>{escape(line)}</li>" for line in matter.told(ledger))
    caption = "What holds each substance over time, by species, kind of object and field."
    return [
        "<h2>Matter</h2>",
        f"<ul>{lines}</ul>",
        drawn(place, "matter", matter.stocks(ledger, hue), caption),
        flows(ledger),
    ]


def flows(ledger: matter.Ledger) -> str:
    """The sums of all flows [mol] by substance and holder."""
    total = {f: ledger.columns[f].sum(axis=0) for f in ledger.flows}
    shown = [f for f in ledger.flows if total[f].any()]
    rows = [
        [
            name,
            holder,
            number(ledger.columns["stock_before"][0, i, k]),
            *(number(total[f][i, k]) for f in shown),
            number(ledger.stock[-1, i, k]),
        ]
        for k, name in enumerate(ledger.substances)
        for i, holder in enumerate(ledger.holders)
        if ledger.stock[:, i, k].any() or any(total[f][i, k] for f in shown)
    ]
    head = ["substance", "in", "at first [mol]", *(f.replace("_", " ") for f in shown), "at last [mol]"]
    return table(head, rows)
