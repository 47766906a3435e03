"""The report of an archipelago: its map, the numbers on its islands, and its migrants."""

from collections.abc import Iterator
from html import escape
from pathlib import Path

from ecs_eco.analysis import archipelago
from ecs_eco.analysis.page import Markup, drawn, page, table, write_text
from ecs_eco.record.archipelago import ISLANDS
from ecs_eco.record.container import inside


def write_archipelago(folder: Path | str, out: Path | str | None = None) -> Path:
    """Write report.html and figures/*.svg into the folder of an archipelago, or into `out`; return the path
    of the report. Raises RecordingError if there is no archipelago or a file is damaged."""
    root = Path(folder)
    place = inside(root, root / "figures").parent if out is None else Path(out)
    islands = archipelago.load_islands(root)
    m = islands.manifest
    title = str(m.get("title") or m.get("world"))
    chart = drawn(
        archipelago.chart(islands),
        place / "figures" / "map.svg",
        (
            "The islands at the end of the run. The area of a disc is the number of organisms of "
            "migrating species; an arrow is as wide as the number of migrants."
        ),
    )
    numbers = drawn(
        archipelago.numbers(islands),
        place / "figures" / "islands.svg",
        (
            "Numbers on each island, with their mean as a thick line, and the number of migrants that "
            "arrived at each barrier."
        ),
    )
    plan = islands.plan
    what = (
        f"World {m['world']}, seed {m['seed']}: {len(plan.names)} islands, graph {plan.graph}, "
        f"{m['tick']:,} ticks with a barrier every {plan.every:,}. Digest {str(m['digest'])[:16]}."
    )
    return write_text(
        place / "report.html",
        page(
            title,
            f"<h1>{escape(title)}</h1>",
            f"<p class='under'>{escape(what)}</p>",
            chart,
            "<h2>Islands</h2>",
            table(
                ["island", *islands.species, "immigrants", "emigrants", "island's own values"],
                _rows(islands, root, place),
            ),
            numbers,
            "<h2>Migrants</h2>",
            *_ways(islands),
        ),
    )


def _rows(islands: archipelago.Islands, root: Path, place: Path) -> Iterator[list[object]]:
    """Yield a row per island: numbers at the end, total migrants, and the island's own values."""
    moved = islands.moved()
    for i, (name, series) in enumerate(islands.series.items()):
        link: object = name
        if place == root and (root / ISLANDS / name / "report.html").is_file():
            link = Markup(f'<a href="{ISLANDS}/{escape(name)}/report.html">{escape(name)}</a>')
        own = ", ".join(f"{key} = {value}" for key, value in islands.plan.islands[name].items())
        yield [
            link,
            *(f"{n:,.0f}" for n in series.n[-1]),
            f"{moved[:, i].sum():,}",
            f"{moved[i].sum():,}",
            own or "–",
        ]


def _ways(islands: archipelago.Islands) -> Iterator[str]:
    """Yield a table of migrants between islands for each migrating species."""
    for species, chance in islands.plan.emigration.items():
        moved = islands.moved(species)
        yield (
            f"<p>{escape(species)}: {moved.sum():,} arrived. At each barrier, an organism leaves with "
            f"probability {chance:g}. Rows: from; columns: to.</p>"
        )
        yield table(
            ["", *islands.plan.names],
            [
                [name, *(f"{k:,}" if k else "–" for k in row)]
                for name, row in zip(islands.plan.names, moved.tolist(), strict=True)
            ],
        )
