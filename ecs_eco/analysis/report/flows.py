"""The part of a report on who ate how much of whom."""

from __future__ import annotations

from html import escape
from pathlib import Path

from ecs_eco.analysis.flows import draw, flows
from ecs_eco.analysis.page import number, table, write_text
from ecs_eco.analysis.runs import Series

_CAPTION = (
    "Energy that eaters gained, a tick, as widths, from whom it was to whom it went. Before them what"
    " came from light, behind them what was burnt (faint) and what died uneaten (full); dashed is "
    "what harmed its eater."
)
_SHARED = " What each food gave was not recorded: what an eater took in is shared among its foods by number."


def blocks(series: Series, place: Path) -> list[str]:
    """The heading, the drawing and its numbers; nothing where nobody ate. `place` gets figures/flows.svg."""
    found = flows(series)
    if found is None:
        return []
    drawn = draw(series, found)
    alone = drawn.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)
    write_text(place / "figures" / "flows.svg", alone)
    rows = [
        [
            f"{m.food} → {m.eater}",
            number(m.energy),
            number(m.number),
            number(m.energy / m.number) if m.number else "–",
        ]
        for m in found.meals
    ]
    caption = escape(_CAPTION + _SHARED * found.shared)
    return [
        "<h2>Who ate whom</h2>",
        f"<figure><div class='wide' tabindex='0'>{drawn}</div><figcaption>{caption}</figcaption></figure>",
        table(["who → by whom", "energy a tick", "number a tick", "energy of each"], rows),
    ]
