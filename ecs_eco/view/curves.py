"""Curves of a world over time, as the message "series": levels at each tick, and totals up to that tick."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ecs_eco.components import Genome, Metabolism, Nervous, Position, Velocity
from ecs_eco.config.models.reporters import DIED
from ecs_eco.ecosystem import World
from ecs_eco.engine.table import Table
from ecs_eco.view import flows
from ecs_eco.view.journal import Journal
from ecs_eco.view.scene import sky

MOST = 4000  # maximum number of points
DEPTH = "mean depth [m]"  # a chart next to the reports; no reporter can have this name
Key = tuple[str, ...]
"""The name of a curve: group and name, plus an inner name in nested groups: ("n", "deer"), ("reports",
reporter, species or ""), ("light", "")."""


class Curves:
    """The points of curves, at increasing ticks: levels, and sums over all ticks up to the point. Of more than
    `most`, `extremes` remain, as in a recording but numbered one higher; none is before the tick `first`."""

    def __init__(self, most: int = MOST) -> None:
        self.most, self.first = most, 0
        self._width, self._widened = 1, -1  # of stretches [ticks]; the last tick when it changed
        self.ticks = np.zeros(0, np.int64)
        self._levels: dict[Key, np.ndarray] = {}
        self._sums: dict[Key, np.ndarray] = {}
        self._first: dict[Key, int] = {}  # tick of the first points that have this curve

    @property
    def last(self) -> int:
        """The tick of the last point; −1 if there is none."""
        return int(self.ticks[-1]) if self.ticks.size else -1

    def add(
        self, ticks: np.ndarray, levels: Mapping[Key, np.ndarray], gains: Mapping[Key, np.ndarray]
    ) -> None:
        """Append points at ticks i64[k]: levels, and the growth of each sum since the last point, f64[k] each."""
        last = self.last
        self._first = {key: int(ticks[0]) for key in (*levels, *gains)} | self._first
        unknown, k = np.full(self.ticks.size, math.nan), len(ticks)
        for key in dict.fromkeys((*self._levels, *levels)):
            new = levels[key] if key in levels else np.full(k, math.nan)
            self._levels[key] = np.append(self._levels.get(key, unknown), new)
        for key in dict.fromkeys((*self._sums, *gains)):
            new = self.total(key) + (gains[key] if key in gains else np.zeros(k))
            self._sums[key] = np.append(self._sums.get(key, 0 * self.ticks), new)
        self.ticks = np.append(self.ticks, ticks)
        n = np.array([of for (group, *_), of in self._levels.items() if group == "n"])
        if (width := stretch(self.last - int(self.ticks[0]), len(n), self.most)) > self._width:
            self._width, self._widened = width, last
        if self._width > 1:
            begin = max(1, self._begin(last))  # without the state before the first tick
            later = begin + extremes(self.ticks[begin:] - 1, n[:, begin:], self._width)
            self._keep(np.union1d(np.arange(max(2, begin)), later))

    def cut(self, tick: int) -> None:
        """Drop the points from this tick onward."""
        self._keep(np.arange(np.searchsorted(self.ticks, tick)))
        for key in [key for key, first in self._first.items() if first >= tick]:
            for held in (self._first, self._levels, self._sums):
                held.pop(key, None)

    def total(self, key: Key) -> float:
        """Return a sum at the last point, 0 if it is unknown."""
        return float(self._sums[key][-1]) if key in self._sums and self.ticks.size else 0.0

    def after(self, tick: int) -> dict[str, Any] | None:
        """Return the points after a tick, and all since any that has gone, as a message; None if none is new."""
        if tick >= self.last:
            return None
        first = max(0, self._begin(tick) - (self._width > 1))  # from a point that the page has
        before = min(first, 1)  # the first rate needs the previous point
        levels = {key: of[first:] for key, of in self._levels.items() if not np.isnan(of[first:]).all()}
        sums = {key: of[first - before :] for key, of in self._sums.items()}
        return series(self.ticks[first - before :], levels, sums, before)

    def _begin(self, tick: int) -> int:
        """Return the index of the first point that may have gone since this tick was the last."""
        begun = tick + 1 if self._width == 1 else (tick - 1) // self._width * self._width + 1
        return 0 if tick <= self._widened else int(np.searchsorted(self.ticks, begun))

    def _keep(self, points: np.ndarray) -> None:
        self.ticks = self.ticks[points]
        for held in (self._levels, self._sums):
            for key, of in held.items():
                held[key] = of[points]


def stretch(ticks: int, species: int, most: int) -> int:
    """Return the shortest stretch [ticks], a power of 2, of which `extremes` keeps no more than `most` points."""
    *some, longest = (1 << k for k in range(ticks.bit_length() + 1))
    return next((w for w in some if -(-ticks // w) * min(w, 2 * species) <= most), longest)


def extremes(ticks: np.ndarray, n: np.ndarray, width: int) -> np.ndarray:
    """Return the points at ticks i64[p] to keep: the last, and those in which a population n f64[species, p] is
    first lowest and highest in each multiple of `width` ticks. Points that it left out before change nothing."""
    at, n = ticks // width, np.nan_to_num(n)
    begin = np.flatnonzero(np.diff(at, prepend=at[0] - 1))
    return np.unique([ticks.size - 1, *np.ravel([np.lexsort((row, at))[begin] for row in (*n, *-n)])])


def series(
    tick: np.ndarray, levels: Mapping[Key, np.ndarray], sums: Mapping[Key, np.ndarray], before: int = 0
) -> dict[str, Any]:
    """Return the message "series" for these ticks i64[n]: levels f64[n] unchanged, sums f64[n] as the mean
    increase per tick since the previous point, NaN as null. The first `before` points (0 or 1) have no levels."""
    span = np.diff(tick)
    rates = {key: np.append(np.nan, np.diff(of) / span)[before:] for key, of in sums.items()}
    groups: dict[str, Any] = {"n": {}, "happiness": {}, "genes": {}}
    out = {"kind": "series", "tick": tick[before:].tolist()} | groups
    for (group, name, *within), values in (dict(levels) | rates).items():
        whole = (values == np.floor(values)).all() and np.abs(values).max(initial=0) < 1e15
        shown = values.astype(np.int64).tolist() if whole else [_plain(value) for value in values.tolist()]
        if within:
            out.setdefault(group, {}).setdefault(name, {})[within[0]] = shown
        elif name:
            out.setdefault(group, {})[name] = shown
        else:
            out[group] = shown
    return out


def _plain(value: float) -> float | None:
    """Return a number rounded to the digits that a chart needs."""
    if not math.isfinite(value):
        return None
    return int(value) if value.is_integer() and abs(value) < 1e15 else float(f"{value:.6g}")


def died(s: str, causes: Iterable[tuple[str, Any]], born: float | np.ndarray) -> dict[Key, Any]:
    """Return the cumulative births and deaths of a species, with deaths also by cause."""
    by_cause = dict(causes)
    return {
        ("births", s): born,
        ("deaths", s): sum(by_cause.values(), start=0.0 * born),
        **{("causes", s, cause): n for cause, n in by_cause.items()},
    }


def sample(curves: Curves, world: World, journal: Journal, genes: Mapping[str, Collection[str]]) -> None:
    """Add the points of all ticks since the last point that the world's recorder has in memory; without a
    recorder, the current state.

    `genes` are the genes of each species that have curves. Their means and the light are known only at the
    last point. Without a recorder, the energy that living organisms took in and burned in the last tick
    replaces the energy flows."""
    if curves.last >= world.tick:
        return
    species = list(genes)
    rows = None if world.recorder is None else world.recorder.since(max(curves.last, curves.first - 1) - 1)
    if rows is None or not rows["tick"].size:
        ticks = np.array([world.tick])
        levels, sums = _state(world, journal, species)
        gains = {key: np.array([total - curves.total(key)]) for key, total in sums.items()}
    else:
        assert world.recorder is not None
        ticks = rows["tick"][:, 0] + 1  # the state after a tick has the number of the next tick
        order = [world.recorder.place[name] for name in species]
        rows = {name: column[:, order] for name, column in rows.items()}
        happy = [s for s in species if feels(world.tables[s])]
        levels = levels_of(rows, species, happy, [s for s in species if Velocity in world.tables[s]])
        reports = {} if world.recorder.reports is None else world.recorder.reports.latest
        for name, said in reports.items():
            for s in [s for s in species if s in said] if isinstance(said, dict) else [""]:
                levels["reports", name, s] = rows[name][:, species.index(s) if s else 0]
        totals = {name: column.cumsum(axis=0, dtype=np.float64) for name, column in rows.items()}
        intake = world.recorder.intake
        gains = sums_of(totals, species, {world.recorder.names[s]: intake.foods for s in intake.eaters})
    now = {("light", ""): sky(world)[0]} | _genes(world, genes)
    levels |= {key: np.append(np.full(ticks.size - 1, np.nan), value) for key, value in now.items()}
    curves.add(ticks, levels, gains)


def levels_of(
    columns: Mapping[str, np.ndarray], species: Sequence[str], happy: Collection[str], movers: Collection[str]
) -> dict[Key, np.ndarray]:
    """Return numbers, mean happiness and mean depths [m] from columns of the series f[ticks, species]."""
    out: dict[Key, np.ndarray] = {}
    for s, name in enumerate(species):
        n = out["n", name] = columns["n"][:, s]
        if name in happy:
            out["happiness", name] = np.where(n > 0, columns["happiness_mean"][:, s], np.nan)
        if name in movers and "depth_mean" in columns:
            out["reports", DEPTH, name] = np.where(n > 0, -columns["depth_mean"][:, s], np.nan)
    return out


def sums_of(
    totals: Mapping[str, np.ndarray], species: Sequence[str], foods: Mapping[str, Sequence[str]]
) -> dict[Key, np.ndarray]:
    """Return births, deaths by cause and energy flows from columns summed over ticks, f[ticks, species]."""
    out: dict[Key, np.ndarray] = {}
    for s, name in enumerate(species):
        causes = ((c.removeprefix(DIED), of[:, s]) for c, of in totals.items() if c.startswith(DIED))
        out |= died(name, [(c, of) for c, of in causes if of[-1]], totals["births"][:, s])
    since = {name: np.vstack([0 * of[:1], of]) for name, of in totals.items()}
    return out | {key: of[1:] for key, of in flows.of_run(since, species, foods).items()}


def _state(
    world: World, journal: Journal, species: Sequence[str]
) -> tuple[dict[Key, np.ndarray], dict[Key, float]]:
    """Return the population sizes, and after the first tick the mean happiness, energy flows and reports; and
    all births and deaths so far."""
    out: dict[Key, Any] = {}
    sums: dict[Key, float] = {}
    for s, name in enumerate(species):
        causes = [(journal.cause(c), float(n)) for c, n in enumerate(journal.died[s].tolist()) if n]
        sums |= died(name, causes, float(journal.born[s]))
        table = world.tables[name]
        rows, out["n", name] = table.rows(), table.n
        if world.tick and table.n and feels(table):
            out["happiness", name] = table[Nervous].happiness[rows].mean(dtype=np.float64)
        if world.tick and table.n and world.space.volume and Velocity in table:
            height = table[Position].z[rows].mean(dtype=np.float64) - float(world.space.size[2])
            out["reports", DEPTH, name] = height
        if world.tick and table.n and Metabolism in table:
            for words, of in zip(
                flows.ENERGY, (table[Metabolism].taken, table[Metabolism].burnt), strict=True
            ):
                out["energy", name, words] = of[rows].sum(dtype=np.float64)
    for name in world.reporters if world.tick else ():
        said = world.measure(name)
        for of, value in (said if isinstance(said, dict) else {"": said}).items():
            out["reports", name, of] = value
    return {key: np.array([value], float) for key, value in out.items()}, sums


def feels(table: Table) -> bool:
    """Return whether a species has a happiness function."""
    return Nervous in table and table.species.nerves.happiness is not None


def _genes(world: World, genes: Mapping[str, Collection[str]]) -> dict[Key, float]:
    """Return the mean values of genes among living organisms."""
    out: dict[Key, float] = {}
    for name, of in genes.items():
        table = world.tables[name]
        if of and table.n:
            decoded = table.species.heredity.layout.decode(table[Genome].loci[table.rows()], list(of))
            out |= {
                ("genes", f"{name}.{gene}"): float(values.mean(dtype=np.float64))
                for gene, values in decoded.items()
            }
    return out
