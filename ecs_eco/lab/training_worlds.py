"""The worlds of pre-training: one, or several in parallel with different values that train the same networks."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ecs_eco.config import WorldConfig, for_training
from ecs_eco.ecosystem import World
from ecs_eco.engine import random

# statistics of species → their columns in a series
COUNTS = {"n": "n", "taken_in": "taken_in", "deaths": "deaths", "happiness": "happiness_mean"}


class TrainingWorlds:
    """`training.worlds` worlds that run in parallel and share the learners of the first. Each has its own
    values of `training.vary`. After `training.renew` ticks, they restart with new values, and a species may
    then use an earlier policy (`training.pool`), which does not learn."""

    def __init__(self, config: WorldConfig, seed: int, threads: int = 1) -> None:
        self.config, self.plan, self.seed, self.threads = config, config.training, seed, threads
        self.tick, self.stage = 0, 0
        self.pool: dict[str, list[dict[str, np.ndarray]]] = {}
        self.series: list[dict[str, np.ndarray]] = []  # statistics of earlier worlds
        self.recorded: list[tuple[int, Any, Any]] = []  # earlier worlds: first tick, updates, actions
        self.learners: dict[str, Any] = {}  # species → Learner or SharedLearner
        self.worlds: list[World] = []
        self._begin()

    def run(self, ticks: int) -> None:
        """Run each world; a world lives for `renew` ticks, plus one more to learn from the last rollout."""
        while ticks > 0:
            part = ticks
            if self.plan.renew:
                left = self.plan.renew + 1 - self.worlds[0].tick
                if left <= 0:
                    self._renew()
                    continue
                part = min(ticks, left)
            for step in range(0, part, self._pace()):
                for world in self.worlds:
                    world.run(min(self._pace(), part - step))
            ticks, self.tick = ticks - part, self.tick + part

    def _pace(self) -> int:
        """Return the number of ticks that one world runs before the next one does: at most a rollout."""
        rollouts = [t.learner.ppo.horizon for t in self.learners.values()]
        return min([16, *rollouts]) if len(self.worlds) > 1 else 10**9

    def brains(self) -> dict[str, Any]:
        """Return the networks that learn, by species."""
        return {
            name: t.species.nerves.brain
            for name, t in self.worlds[0].tables.items()
            if t.species.nerves is not None and t.species.nerves.brain is not None
        }

    def reports(self) -> dict[str, dict[str, float | None]]:
        """Return the statistics of each species' last update, if any; undefined values are None."""
        last_reports = {}
        for name, table in self.worlds[0].tables.items():
            if table.species.nerves is not None and table.species.nerves.learning:
                reports = [w.tables[name].species.nerves.reports for w in self.worlds]
                last: dict[str, float] = max(
                    (r[-1] for r in reports if r), key=lambda r: r["tick"], default={}
                )
                last_reports[name] = {k: v if np.isfinite(v) else None for k, v in last.items()}
        return last_reports

    def past(self) -> dict[str, np.ndarray]:
        """Return the counts summed over worlds, and mean happiness: f64[ticks, species] each."""
        parts = [counts_of(world) for world in self.worlds]
        return {
            k: (np.mean if k == "happiness" else np.sum)([part[k] for part in parts], axis=0) for k in COUNTS
        }

    def history(self) -> tuple[Any, Any]:
        """Return tables of all updates and of the actions in all worlds, with the ticks of the training."""
        import pyarrow as pa

        plain = [[], []]  # type: list[list[Any]]
        for begin, *tables in [*self.recorded, *self._recordings()]:
            for kind, table in zip(plain, tables, strict=True):
                for name in {"species", "action"}.intersection(table.column_names):
                    at = table.column_names.index(name)
                    table = table.set_column(at, name, table[name].cast(pa.string()))
                kind.append(table.set_column(0, "tick", pa.array(table["tick"].to_numpy() + begin)))
        updates, actions = (pa.concat_tables(tables) for tables in plain)
        return updates.sort_by("tick"), actions.group_by(["tick", "species", "action"]).aggregate(
            [("n", "sum"), ("of", "sum")]
        ).rename_columns(["tick", "species", "action", "n", "of"])

    def _recordings(self) -> list[tuple[int, Any, Any]]:
        begin = self.tick - self.worlds[0].tick
        return [(begin, w.recorder.learning_series(), w.recorder.action_series()) for w in self.worlds]

    def _renew(self) -> None:
        self.recorded += self._recordings()
        self.series.append(self.past())
        for name, brain in self.brains().items():
            self.pool.setdefault(name, []).append(brain.state())
        self.stage += 1
        self._begin()

    def _begin(self) -> None:
        """Create the worlds of a stage and give them the learning networks."""
        k, first = self.plan.worlds, not self.worlds
        values = drawn(self.plan.vary, k, random.tick_key(self.seed, self.stage))
        self.worlds = []
        for i in range(k):
            config = for_training(self.config, values[i])
            number = self.stage * k + i
            seed = self.seed if number == 0 else int(random.tick_key(self.seed, number)) & 0x7FFFFFFFFFFFFFFF
            self.worlds.append(
                World.from_config(
                    config, seed=seed, policies="untrained", threads=self.threads, training=True, learn=True
                )
            )
        if first and (k > 1 or self.plan.renew):
            from ecs_eco.learning.shared import SharedLearner  # loads torch

            for name, table in self.worlds[0].tables.items():
                if table.species.nerves is not None and table.species.nerves.learner is not None:
                    self.learners[name] = SharedLearner(table.species.nerves.learner, k)
        for name, learner in self.learners.items():
            for i, world in enumerate(self.worlds):
                self._hand(world.tables[name].species.nerves, name, learner, i)

    def _hand(self, nerves: Any, name: str, together: Any, i: int) -> None:
        """Give a species in world i the learning network, or an earlier network from the pool."""
        share, pool = together.shares[i], self.pool.get(name, [])
        key = random.tick_key(self.seed, self.stage * self.plan.worlds + i)
        u = random.draw_many(
            key, np.arange(2, dtype=np.uint64), random.PLACE + (list(self.learners).index(name) << 8)
        )
        earlier = i > 0 and bool(pool) and float(u[0]) < self.plan.pool
        share.renew(active=not earlier)
        if earlier:
            nerves.brain.load(pool[int(float(u[1]) * len(pool))])
            nerves.learner, nerves.learning = None, False
        else:
            nerves.brain, nerves.learner = together.learner.brain, share


def counts_of(world: World) -> dict[str, np.ndarray]:
    """Return the statistics of a world so far: f64[ticks, species] each."""
    series, shape = world.series().select([*COUNTS.values()]).to_pydict(), (-1, len(world.recorder.names))
    return {name: np.asarray(series[column], float).reshape(shape) for name, column in COUNTS.items()}


def curves(
    whole: Sequence[Mapping[str, np.ndarray]], names: Sequence[str], every: int, dt: float
) -> dict[str, dict[str, Any]]:
    """Return statistics of each species, averaged over blocks of `every` ticks of consecutive series."""
    out: dict[str, dict[str, Any]] = {}
    for i, name in enumerate(names):
        column = {k: np.concatenate([part[k][:, i] for part in whole]) for k in COUNTS}
        starts = range(0, len(column["n"]), every)
        total = {k: np.array([v[a : a + every].sum() for a in starts]) for k, v in column.items()}
        alive = np.maximum(total["n"], 1) * dt
        out[name] = {
            "tick": [min(a + every, len(column["n"])) for a in starts],
            "intake": (total["taken_in"] / alive).tolist(),
            "deaths": (total["deaths"] / alive).tolist(),
            "happiness": [float(column["happiness"][a : a + every].mean()) for a in starts],
        }
    return out


def drawn(vary: Mapping[str, Sequence[float]], worlds: int, key: np.uint64) -> list[dict[str, Any]]:
    """Return a value for each key and world: each of `worlds` equal parts of a range is used once, in an
    order that differs between keys.

    This is a Latin hypercube (McKay, Beckman & Conover 1979). Parts are equal on a log scale if both ends are
    positive, otherwise on a linear scale; values are integers if both ends are integers.
    """
    out: list[dict[str, Any]] = [{} for _ in range(worlds)]
    for j, (name, (low, high)) in enumerate(vary.items()):
        u = random.draw_many(
            key, np.arange(2 * worlds, dtype=np.uint64), random.PLACE + ((j + 1) << 16)
        ).astype(float)
        share = (np.argsort(np.argsort(u[:worlds])) + u[worlds:]) / worlds
        numbers = low * (high / low) ** share if low > 0 and high > 0 else low + (high - low) * share
        whole = isinstance(low, int) and isinstance(high, int)
        for i, value in enumerate(numbers):
            out[i][name] = round(value) if whole else float(value)
    return out
