"""The curves of a watched world, its births and deaths, counted as they happen, and its story."""

from __future__ import annotations

import math
from copy import copy
from typing import Any

import numpy as np

from ecs_eco.components import Metabolism, Position, Velocity
from ecs_eco.ecosystem import World
from ecs_eco.engine.table import Table
from ecs_eco.view.flows import Flows
from ecs_eco.view.story import Story, foods_of

MOST = 4000  # points


class Curves:
    """Points by tick, each a flat dict of numbers; a name that a point lacks is null there."""

    def __init__(self, most: int = MOST) -> None:
        self.most, self.every = most, 1
        self.ticks: list[int] = []
        self.points: list[dict[tuple[str, ...], float]] = []

    def add(self, tick: int, point: dict[tuple[str, ...], float]) -> None:
        """Add a point {(group, name): number}, of what reporters say {("reports", reporter, species or ""):
        number}; when there are `most`, every second one is dropped."""
        if len(self.ticks) >= self.most:
            del self.ticks[1::2], self.points[1::2]
        self.ticks.append(tick)
        self.points.append(point)

    def cut(self, tick: int) -> None:
        """Forget the points of a tick and of later ones."""
        while self.ticks and self.ticks[-1] >= tick:
            del self.ticks[-1], self.points[-1]

    def after(self, tick: int) -> dict[str, Any] | None:
        """Return the points of later ticks as a message; None where there are none."""
        first = len(self.ticks)
        while first and self.ticks[first - 1] > tick:
            first -= 1
        if first == len(self.ticks):
            return None
        points = self.points[first:]
        out: dict[str, Any] = {
            "kind": "series",
            "tick": self.ticks[first:],
            "n": {},
            "happiness": {},
            "genes": {},
        }
        for key in dict.fromkeys(key for point in points for key in point):
            values = [_plain(point.get(key)) for point in points]
            group, name, *species = key
            if species:
                out.setdefault(group, {}).setdefault(name, {})[species[0]] = values
            elif name:
                out.setdefault(group, {})[name] = values
            else:
                out[group] = values
        return out


def _plain(value: float | None) -> float | None:
    if value is None or not math.isfinite(value):
        return None
    return value if isinstance(value, int) else float(f"{value:.6g}")


def by_species(said: dict[str, Any]) -> dict[str, list[float | None]]:
    """Return what a reporter said by species, or by "" where all have the same number, the world's."""
    first, *others = said.values()
    if all(np.array_equal(first, other, equal_nan=True) for other in others):
        said = {"": first}
    return {
        name: [_plain(float(v)) for v in values] for name, values in said.items() if np.isfinite(values).any()
    }


CAUSES = 256
DEPTH = "mean depth [m]"  # a chart beside those of reporters, which cannot be called so
KEPT = ("births", "_deaths", "bred", "_last", "_sampled")
PENDING = 1000  # batches of deaths that are not counted yet
EVERY = 5  # ticks from one look at the numbers to the next; extinctions are seen at once


class Tally:
    """Counts births and deaths by cause since it was made; it listens, and changes nothing."""

    def __init__(self, world: World, species: list[str]) -> None:
        self.world, self.species = world, species
        self._place = {name: s for s, name in enumerate(species)}
        self.births = np.zeros(len(species), np.int64)
        self._deaths = np.zeros((len(species), CAUSES), np.int64)
        self._pending: list[tuple[int, np.ndarray]] = []  # species and causes of deaths that are not counted
        self.bred = np.zeros(len(species), np.bool_)
        config = None if world.config is None else world.config.model_dump(include={"species"})
        self.foods = foods_of(config)
        self.story = Story(species, self.foods, lambda c: world.causes[c - 1] if c else "unknown")
        self.flows = Flows(world)
        self._tables = [world.tables[name] for name in species]
        self._last, self._now = -EVERY, True  # when the story was told last; whether it is to be told at once
        self._sampled: tuple[int, np.ndarray, np.ndarray] | None = None
        world.on_birth.append(self._was_born)
        world.on_death.append(self._has_died)

    def _was_born(self, table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        s = self._place.get(table.name)
        if s is not None:
            self.births[s] += rows.size
            self._now |= table.n <= rows.size  # there was none
            if not self.bred[s]:
                self.bred[s] = parents.any()

    def _has_died(self, table: Table, rows: np.ndarray) -> None:
        s = self._place.get(table.name)
        if s is not None:
            self._pending.append((s, table.cause[rows]))
            self._now |= table.n <= rows.size  # there is none

    @property
    def deaths(self) -> np.ndarray:
        """Deaths of each species by cause, from 1 as in world.causes: i64[species, causes]."""
        self._count()
        return self._deaths

    def _count(self) -> None:
        if self._pending:
            cells = np.concatenate([s * CAUSES + causes.astype(np.intp) for s, causes in self._pending])
            self._pending.clear()
            self._deaths += np.bincount(cells, minlength=self._deaths.size).reshape(self._deaths.shape)

    def passed(self) -> None:
        """Take note of a tick that has passed."""
        if self._now or self.world.tick >= self._last + EVERY:
            self._last, self._now = self.world.tick, False
            over = max(0, self.world.tick - 1)  # as in the records: the last tick that is over
            n = np.array([table.n for table in self._tables], np.int64)
            self.story.note(over, n, self.births, lambda: self.deaths, self.bred)
            if len(self._pending) > PENDING:
                self._count()

    def _energy(self, name: str, table: Table) -> dict[tuple[str, ...], float]:
        """Return what the living of a species took in and burnt in the last tick [energy]."""
        if Metabolism not in table or not table.n:
            return {}
        m, rows = table[Metabolism], table.rows()
        return {
            ("energy", name, "taken in"): float(m.taken[rows].sum(dtype=np.float64)),
            ("energy", name, "burnt"): float(m.burnt[rows].sum(dtype=np.float64)),
        }

    def _depths(self) -> dict[tuple[str, ...], float]:
        """Return how deep those of each moving species are in water, on average, as heights below 0 [m]."""
        if not self.world.space.volume:
            return {}
        top, moving = float(self.world.space.size[2]), [t for t in self._tables if t.n and Velocity in t]
        return {
            ("reports", DEPTH, t.name): float(t[Position].z[t.rows()].mean(dtype=np.float64)) - top
            for t in moving
        }

    def mark(self) -> dict[str, Any]:
        """Return what has been counted and told so far."""
        self._count()
        return {name: copy(getattr(self, name)) for name in KEPT} | {
            "story": self.story.mark(),
            "flows": self.flows.mark(),
        }

    def go_back(self, mark: dict[str, Any]) -> None:
        """Count and tell on from a mark."""
        self._pending.clear()
        self._now = True
        for name in KEPT:
            setattr(self, name, copy(mark[name]))
        self.story.go_back(mark["story"])
        self.flows.go_back(mark["flows"])

    def rates(self) -> dict[tuple[str, ...], float]:
        """Return births and deaths by cause, a tick, since the last call: points of curves."""
        tick, before, point = self.world.tick, self._sampled, self.flows.rates()
        self._sampled = tick, self.births.copy(), self.deaths.copy()
        if before is None or tick <= before[0]:
            return {}
        span = tick - before[0]
        point |= self._depths()
        for s, name in enumerate(self.species):
            point["births", name] = round(float(self.births[s] - before[1][s]) / span, 4)
            died = self.deaths[s] - before[2][s]
            point["deaths", name] = round(float(died.sum()) / span, 4)
            point |= self._energy(name, self._tables[s])
            for cause in np.flatnonzero(self.deaths[s]).tolist():
                point["causes", name, self.world.causes[cause - 1]] = round(float(died[cause]) / span, 4)
        return point
