"""An archipelago's results and report: population sizes by island, and migrants by route."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.page import Markup, drawn, page, table, verdict, write_text
from ecs_eco.analysis.palette import AXIS, INK
from ecs_eco.analysis.runs import Series, load_series, tables
from ecs_eco.analysis.style import Figure, colors_of, panels, styled
from ecs_eco.config.models.archipelago import Archipelago
from ecs_eco.engine.errors import RecordingError, in_words
from ecs_eco.record.archipelago import ISLANDS, check_island, read


@dataclass(frozen=True)
class Islands:
    """An archipelago: `series` by island, and `moves` with columns tick, species, from, to, number of arrivals."""

    manifest: dict[str, Any]
    plan: Archipelago
    series: dict[str, Series]
    moves: np.ndarray

    @property
    def first(self) -> Series:
        """The series of the first island."""
        return next(iter(self.series.values()))

    @property
    def species(self) -> tuple[str, ...]:
        """The species, in world-file order."""
        return self.first.species

    @property
    def migrants(self) -> list[str]:
        """The species that migrate."""
        return [s for s in self.species if s in self.plan.migration_probability]

    def moved(self, species: str | None = None) -> np.ndarray:
        """Return the number of migrants between islands, for all species or one: i64[from, to]."""
        out = np.zeros((len(self.series),) * 2, np.int64)
        rows = self.moves if species is None else self.moves[self.moves[:, 1] == self.species.index(species)]
        np.add.at(out, (rows[:, 2], rows[:, 3]), rows[:, 4])
        return out

    def over_time(self, species: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the ticks of the barriers, and the number of a species' migrants at each barrier."""
        rows = self.moves[self.moves[:, 1] == self.species.index(species)]
        every, end = self.plan.migration_interval, int(self.manifest["tick"])
        ticks = np.arange(every, end, every)
        return ticks, np.array([rows[rows[:, 0] == tick, 4].sum() for tick in ticks], np.int64)


def load_islands(folder: Path | str) -> Islands:
    """Read an archipelago's folder; raise RecordingError if there is none or a file is damaged."""
    root = Path(folder)
    manifest = read(root)
    plan = Archipelago.model_validate(manifest["config"]["archipelago"])
    whole = {name: load_series(root / ISLANDS / name) for name in plan.names}
    series = {}
    for name, one in whole.items():
        check_island(root / ISLANDS / name, one.manifest, manifest["hash"], name)
        before = one.ticks < manifest["tick"]  # in an interrupted run, some islands may be ahead
        if before.sum() != manifest["tick"]:
            fault = f"has {before.sum()} ticks, but its archipelago has {manifest['tick']}"
            raise RecordingError(f"{root / ISLANDS / name}: {fault}")
        columns = {key: column[before] for key, column in one.columns.items()}
        series[name] = Series(one.ticks[before], one.species, columns, one.manifest)
    species = next(iter(series.values())).species
    moves: list[np.ndarray] = []
    for number, name in enumerate(plan.names):
        for part in tables(root / ISLANDS / name, "arrivals"):
            who = [species.index(kind) for kind in part["species"].to_pylist()]
            origin = [plan.names.index(island) for island in part["origin"].to_pylist()]
            rows = np.stack([np.asarray(part["tick"].to_numpy(), np.int64), who, origin], 1)
            found, count = np.unique(rows[rows[:, 0] < manifest["tick"]], axis=0, return_counts=True)
            moves.append(np.column_stack([found, np.full(len(found), number), count]))
    return Islands(manifest, plan, series, np.concatenate(moves) if moves else np.zeros((0, 5), np.int64))


def places(plan: Archipelago) -> np.ndarray:
    """Return islands' positions on a map from 0 to 1, f64[n, 2]: on a grid for a grid graph, or on a circle."""
    n = len(plan.names)
    if plan.graph == "grid":
        width = math.ceil(math.sqrt(n))
        x, y = np.arange(n) % width, np.arange(n) // width
        return np.stack([(x + 0.5) / width, 1 - (y + 0.5) / math.ceil(n / width)], 1)
    angle = np.pi / 2 - 2 * np.pi * np.arange(n) / n
    return 0.5 + 0.36 * np.stack([np.cos(angle), np.sin(angle)], 1)


@styled
def chart(islands: Islands) -> Figure:
    """Draw a map with islands divided into sectors by migrating species, and arrows for migrants."""
    from matplotlib.patches import FancyArrowPatch, Wedge

    wander, hue = islands.migrants or list(islands.species), colors_of(islands.first)
    figure, ((ax,),) = panels(1, 1, 6.4, 6.4)
    at, moved = places(islands.plan), islands.moved()
    now = {name: [series.n[-1][series.index(s)] for s in wander] for name, series in islands.series.items()}
    most = max(max(sum(n) for n in now.values()), 1)
    arrow: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 10, "connectionstyle": "arc3,rad=0.12"}
    arrow |= {"shrinkA": 26, "shrinkB": 26, "color": AXIS, "alpha": 0.8, "zorder": 1}
    for i, targets in enumerate(islands.plan.neighbours()):
        for j in targets:
            wide = 0.4 + 3.6 * moved[i, j] / max(moved.max(), 1)
            ax.add_patch(FancyArrowPatch(tuple(at[i]), tuple(at[j]), linewidth=wide, **arrow))
    for (x, y), (name, n) in zip(at, now.items(), strict=True):
        radius, total, turned = 0.025 + 0.04 * math.sqrt(sum(n) / most), max(sum(n), 1), 90.0
        for species, count in zip(wander, n, strict=True):
            begin = turned - 360 * count / total
            ax.add_patch(Wedge((x, y), radius, begin, turned, color=hue[species], zorder=2))
            turned = begin
        text = {"textcoords": "offset points", "ha": "center", "va": "top", "fontsize": 9}
        ax.annotate(f"{name}\n{sum(n):,.0f}", (x, y), (0, -30), **text)
    handles = [Wedge((0, 0), 1, 0, 1, color=hue[s], label=s) for s in wander]
    ax.legend(handles=handles, loc="upper right", frameon=False)
    ax.set(xlim=(-0.05, 1.05), ylim=(-0.08, 1.05), aspect="equal")
    ax.axis("off")
    return figure


@styled
def numbers(islands: Islands) -> Figure:
    """Plot the population sizes of each migrating species, one line per island, with its migrants below."""
    wander, hue = islands.migrants or list(islands.species[:1]), colors_of(islands.first)
    figure, axes = panels(2, len(wander), 4.4 * max(len(wander), 1.6), 5.0, sharex=True)
    for column, species in enumerate(wander):
        top, bottom = axes[0, column], axes[1, column]
        for name, series in islands.series.items():
            top.plot(series.ticks, series.of(species), color=hue[species], alpha=0.6, lw=0.9, label=name)
        total = np.sum([series.of(species) for series in islands.series.values()], axis=0)
        top.plot(islands.first.ticks, total / len(islands.series), color=INK, lw=1.6, label="mean")
        top.set(title=species, ylabel="number per island" if not column else "", ylim=(0, None))
        ticks, count = islands.over_time(species)
        bottom.bar(ticks, count, width=0.8 * islands.plan.migration_interval, color=hue[species])
        bottom.set(xlabel="tick", ylabel="migrants at a barrier" if not column else "")
    return figure


_MAP = (
    "The islands at the end of the run. Disc area: number of organisms of migrating species. Arrow width: "
    "number of migrants."
)
_NUMBERS = (
    "Population sizes on each island (thick line: their mean), and migrants that arrived at each barrier."
)


def write_archipelago(folder: Path | str, out: Path | str | None = None) -> Path:
    """Write report.html and figures/*.svg to an archipelago's folder or to `out`; return the report's path.
    Raises RecordingError if there is no archipelago or a file is damaged."""
    root = Path(folder)
    place = root if out is None else Path(out)
    islands = load_islands(root)
    m = islands.manifest
    title = str(m.get("title") or m.get("world"))
    picture = drawn(chart(islands), place / "figures" / "map.svg", _MAP)
    curves = drawn(numbers(islands), place / "figures" / "islands.svg", _NUMBERS)
    plan = islands.plan
    what = (
        f"World {m['world']}, seed {m['seed']}: {len(plan.names)} islands, graph {plan.graph}, "
        f"{m['tick']:,} ticks with a barrier every {plan.migration_interval:,}. Digest {str(m['digest'])[:16]}."
    )
    head = ["island", *islands.species, "immigrants", "emigrants", "island's own values"]
    blocks = [
        f"<h1>{escape(title)}</h1>",
        verdict(*opening(islands)),
        f"<p class='under'>{escape(what)}</p>",
        picture,
        "<h2>Islands</h2>",
        table(head, _rows(islands, root, place)),
        curves,
        "<h2>Migrants</h2>",
        *_ways(islands),
    ]
    return write_text(place / "report.html", page(title, *blocks))


def opening(islands: Islands) -> tuple[list[str], bool]:
    """Return sentences on the islands where species died out and on migrants, and whether a species died out."""
    lines, many = [], len(islands.series)
    for s, name in enumerate(islands.species):
        gone = {
            island: int(series.extinct[s])
            for island, series in islands.series.items()
            if series.n[:, s].any() and np.isfinite(series.extinct[s])
        }
        if gone:
            order = sorted(gone.items(), key=lambda one: one[1])
            places = [f"{island} at tick {tick:,}" for island, tick in order[:3]]
            places += [f"{len(gone) - 3} more"] * (len(gone) > 3)
            lines.append(f"{name} died out on {len(gone)} of {many} islands ({in_words(places)}).")
    if not (lost := bool(lines)):
        lines.append(
            f"On each island, all species that it began with are alive after {islands.manifest['tick']:,} ticks."
        )
    counts = {name: islands.moved(name).sum() for name in islands.migrants}
    if counts:
        lines.append(f"Migrants that arrived: {in_words(f'{n:,} {name}' for name, n in counts.items())}.")
    return lines, lost


def _rows(islands: Islands, root: Path, place: Path) -> Iterator[list[object]]:
    """Yield a row for each island: final population sizes, total migrants, and the island's own values."""
    moved = islands.moved()
    for i, (name, series) in enumerate(islands.series.items()):
        link: object = name
        if place == root and (root / ISLANDS / name / "report.html").is_file():
            link = Markup(f'<a href="{ISLANDS}/{escape(name)}/report.html">{escape(name)}</a>')
        own = ", ".join(f"{key} = {value}" for key, value in islands.plan.islands[name].items())
        migrants = f"{moved[:, i].sum():,}", f"{moved[i].sum():,}"
        yield [link, *(f"{n:,.0f}" for n in series.n[-1]), *migrants, own or "–"]


def _ways(islands: Islands) -> Iterator[str]:
    """Yield a table of migrants between islands for each migrating species."""
    for species, chance in islands.plan.migration_probability.items():
        moved = islands.moved(species)
        yield (
            f"<p>{escape(species)}: {moved.sum():,} arrived. At each barrier, an organism leaves with "
            f"probability {chance:g}. Rows: from; columns: to.</p>"
        )
        counts = ([f"{k:,}" if k else "–" for k in row] for row in moved.tolist())
        rows = ([name, *row] for name, row in zip(islands.plan.names, counts, strict=True))
        yield table(["", *islands.plan.names], rows)
