"""Follow some organisms of a world while it runs, and sum what happens to them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.components import Metabolism
from ecs_eco.ecosystem import World
from ecs_eco.engine.hooks import listening
from ecs_eco.engine.table import Table
from ecs_eco.engine.uids import matched
from ecs_eco.life.births import rows_of
from ecs_eco.nervous.thoughts import minds, thinkers
from ecs_eco.runs.requests import repeat_requests

SPARSE = ("died: ", "meals: ")  # measures that are 0 in forks where they do not occur


class Followed:
    """Counts what happens to organisms with these uids u64[n], sorted, without changing the world."""

    def __init__(self, world: World, table: Table, uids: np.ndarray) -> None:
        self.world, self.table, self.uids, self.start = world, table, uids, world.tick
        n, nerves = uids.size, table.species.nerves
        self.actions = [] if nerves is None else [f"{group}.{name}" for group, name in nerves.actions]
        self.alive = np.ones(n, np.bool_)
        self.births, self.lived, self.energy, self.decided = (np.zeros(n) for _ in range(4))
        self.cause = np.zeros(n, np.int64)  # 0: alive
        self.meals = {name: np.zeros(n) for name in world.tables}
        self.acted = np.zeros((n, len(self.actions)))

    def run(self, ticks: int, manifest: dict[str, Any]) -> None:
        """Run the world until all these organisms are dead, but at most for a number of ticks."""
        world = self.world
        with (
            listening(world.on_birth, self._born),
            listening(world.on_death, self._died),
            listening(world.before_tick, lambda: repeat_requests(world, manifest)),
        ):
            while self.alive.any() and world.tick < self.start + ticks:
                world.run(1)
                at = np.flatnonzero(self.alive)
                self._passed(rows_of(self.table, self.uids[at]), at)
        self.lived[self.alive] = world.tick - self.start

    def means(self, group: np.ndarray, groups: int) -> dict[str, list[float]]:
        """Return the mean of each measure in each group i64[n] (−1: none): NaN in empty groups."""
        own = [group == g for g in range(groups)]

        def mean(values: np.ndarray) -> list[float]:
            return [float(values[some].mean()) if some.any() else np.nan for some in own]

        measures = {"births": self.births, "survival": self.lived, "alive": self.alive}
        measures |= {f"died: {c}": self.cause == i for i, c in enumerate(self.world.causes, 1)}
        if Metabolism in self.table:
            measures["energy"] = self.energy
        measures |= {f"meals: {name}": n for name, n in self.meals.items()}
        out = {name: mean(values) for name, values in measures.items()}
        out = {name: values for name, values in out.items() if not name.startswith(SPARSE) or any(values)}
        for k, name in enumerate(self.actions):
            with np.errstate(invalid="ignore"):
                sums = [(self.acted[some, k].sum(), self.decided[some].sum()) for some in own]
                out[f"action: {name}"] = [float(np.divide(acted, decided)) for acted, decided in sums]
        return out

    def _at(self, uids: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return which of these uids are followed, as indices i64[k], and their places i64[k]."""
        place, there = matched(self.uids, uids)
        return np.flatnonzero(there), place[there]

    def _born(self, table: Table, rows: np.ndarray, first: np.ndarray, second: np.ndarray) -> None:
        if table is self.table:
            for parents in (first, np.where(second == first, np.uint64(0), second)):
                np.add.at(self.births, self._at(parents)[1], 1)

    def _died(self, table: Table, rows: np.ndarray) -> None:
        np.add.at(self.meals[table.name], self._at(table.killer[rows])[1], 1)
        if table is self.table:
            which, at = self._at(table.uid[rows])
            if self.world.ticking:
                self._passed(rows[which], at)
            self.alive[at], self.cause[at] = False, table.cause[rows[which]]
            self.lived[at] = self.world.tick - self.start

    def _passed(self, rows: np.ndarray, at: np.ndarray) -> None:
        """Add the flows and decisions of a tick of organisms in rows i64[k], at these places."""
        if Metabolism in self.table:
            self.energy[at] += self.table[Metabolism].taken[rows]
        if self.actions and rows.size:
            thinking, heads = thinkers(self.table, self.uids[at])
            if thinking.size:
                at = self._at(self.table.uid[thinking])[1]
                self.decided[at] += 1
                self.acted[at] += minds(self.table, thinking, heads).decision


# --- results ------------------------------------------------------------------------------------------------
