"""Pre-training and its evaluation: policies learn from random weights while respawning keeps numbers constant, in
one world, or in several with different values that train the same networks."""

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.compare import clean
from ecs_eco.analysis.learning import acts_of, thinned, updates_of
from ecs_eco.analysis.seed_grid import mean_interval
from ecs_eco.config import WorldConfig, for_training, load
from ecs_eco.config.loading import WorldSource, changed
from ecs_eco.config.ranges import key_of, real_key
from ecs_eco.ecosystem import World
from ecs_eco.engine import random
from ecs_eco.engine.arguments import called_with, seed_number, whole_number
from ecs_eco.learning.weights import hash_of, save as save_weights
from ecs_eco.life.reconfigure import reconfigure
from ecs_eco.record.seal import write_manifest
from ecs_eco.worlds.policies import names_of


def pretrain(
    config: WorldSource,
    seed: int | None = None,
    ticks: int | None = None,
    out: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    *,
    threads: int = 1,
    points: int = 30,
    trust: bool = False,
) -> dict[str, Any]:
    """Train the policies of all species that have one.

    Parameters
    ----------
    config : str, Path, Mapping or WorldConfig
        A world; its `training` section configures the training.
    seed : int, optional
        Seed; default: `seed` in the world file.
    ticks : int, optional
        Length of each training world; default: `training.ticks`.
    out : str or Path, optional
        Folder for `<species>.safetensors` and training.json.
    progress : callable, optional
        `progress(done, ticks)`.
    threads : int, default 1
        Number of threads, which affects speed, never results.
    points : int, default 30
        Number of points per curve.
    trust : bool, default False
        Whether code listed in the world file can run in this process.

    Returns
    -------
    dict
        "policies": weights by species; "curves": by species and point, intake and deaths per animal per
        second, and mean happiness, over all training worlds; "learning": each update; "actions": how often
        each action was taken.

    Examples
    --------
    >>> from ecs_eco.lab import pretrain
    >>> result = pretrain("predator-prey", seed=1, ticks=4, out="policies")
    >>> sorted(result["policies"])
    ['deer', 'wolf']
    """
    called_with("progress", progress, "done", "ticks")
    config = config if isinstance(config, WorldConfig) and not trust else load(config, trust=trust)
    ticks = config.training.ticks if ticks is None else whole_number("ticks", ticks, 1)
    seed = config.seed if seed is None else seed_number(seed)
    begin = time.perf_counter()
    training_worlds = TrainingWorlds(config, seed, threads)
    last: dict[str, list[dict[str, np.ndarray]]] = {}
    every = max(1, ticks // points)
    for done in range(0, ticks, every):
        training_worlds.ramp(done / ticks)
        training_worlds.run(min(every, ticks - done))
        if progress is not None:
            progress(training_worlds.tick, ticks)
        if training_worlds.tick > (1 - config.training.average) * ticks or training_worlds.tick == ticks:
            for name, brain in training_worlds.brains().items():
                last.setdefault(name, []).append(brain.state())
    policies = {name: mean_weights(states) for name, states in last.items()}
    whole = [*training_worlds.series, training_worlds.past()]
    result = {
        "world": config.name,
        "config_hash": config.config_hash,
        "seed": training_worlds.seed,
        "ticks": ticks,
        "seconds": time.perf_counter() - begin,
        "curves": curves(whole, training_worlds.worlds[0].recorder.names, every, config.dt),
        "policies": policies,
        "names": {name: names_of(config, name) for name in policies},
        "reports": training_worlds.reports(),
        **over_time(training_worlds),
    }
    if out is not None:
        save(result, Path(out))
    return result


def over_time(training_worlds: "TrainingWorlds") -> dict[str, Any]:
    """Return each species' updates and frequencies of actions as lists; undefined values are None."""
    updates, actions = training_worlds.history()
    learning = {
        s: {"tick": u.ticks.tolist(), **{word: clean(v.astype(float)) for word, v in u.columns.items()}}
        for s, u in updates_of(updates).items()
    }
    acts = {}
    for s, a in acts_of(actions).items():
        shares = [thinned(a.ticks, a.share[:, i]) for i in range(len(a.actions))]
        acts[s] = {
            "tick": shares[0][0].tolist(),
            **{name: clean(c[1].astype(float)) for name, c in zip(a.actions, shares, strict=True)},
        }
    return {"learning": learning, "actions": acts}


def save(result: dict[str, Any], out: Path) -> None:
    """Write policies as sealed safetensors, and everything else, with their hashes, to training.json."""
    out.mkdir(parents=True, exist_ok=True)
    for name, weights in result["policies"].items():
        save_weights(out / f"{name}.safetensors", weights, result["names"][name])
    write_manifest(
        out,
        {k: v for k, v in result.items() if k not in ("policies", "names")}
        | {"weights": {name: hash_of(out / f"{name}.safetensors") for name in result["policies"]}},
        "training.json",
    )


def mean_weights(states: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return the mean of a network's states, which varies less than the last state (Polyak & Juditsky 1992)."""
    return {
        k: np.asarray(np.mean([s[k] for s in states], axis=0, dtype=np.float64), np.float32)
        for k in states[0]
    }


SEEDS = 3
TICKS = 300  # maximum length of each run


def against_random(
    config: WorldConfig, policies: Path | str, seed: int, ticks: int = TICKS, seeds: int = SEEDS
) -> dict[str, Any]:
    """Run trained and random policies, both without learning, in the training world with the same seeds. Return
    {"trained": [mean, low, high], "random": …, "difference": …} by species and measure, with 95% intervals."""
    found = {
        arm: [_measured(config, chosen, seed + 1 + k, ticks) for k in range(seeds)]
        for arm, chosen in (("trained", str(policies)), ("random", "random"))
    }
    out: dict[str, Any] = {}
    for s, measures in found["trained"][0].items():
        for word in measures:
            trained, random = (np.array([[run[s][word] for run in runs]]) for runs in found.values())
            both = {"trained": trained, "random": random, "difference": trained - random}
            out.setdefault(s, {})[word] = {arm: clean(mean_interval(x)) for arm, x in both.items()}
    return out


def train_and_evaluate(
    config: WorldConfig, seed: int, ticks: int, out: Path, progress: Callable[[int, int], None] | None = None
) -> dict[str, Any]:
    """Train policies and write them to a folder; return the result of `pretrain` with the key "against_random"."""
    config._code.pass_on()
    result = pretrain(config, seed, ticks, out, progress)
    result["against_random"] = against_random(config, out, seed, min(ticks, TICKS))
    save(result, out)
    return result


def _measured(config: WorldConfig, policies: str, seed: int, ticks: int) -> dict[str, dict[str, float]]:
    world = World.from_config(for_training(config), seed=seed, policies=policies, training=True, learn=False)
    world.run(ticks)
    measured = curves([counts_of(world)], world.recorder.names, ticks, config.dt)
    return {
        name: {word: measured[name][word][0] for word in ("happiness", "intake", "deaths")}
        for name in measured
        if (nerves := world.tables[name].species.nerves) is not None and nerves.policy
    }


# statistics of species → their columns in a series
COUNTS = {"n": "n", "taken_in": "taken_in", "deaths": "deaths", "happiness": "happiness_mean"}


class TrainingWorlds:
    """`training.worlds` worlds that run in parallel and share the learners of the first. Each has its own
    values of `training.vary`. After `training.renew` ticks, they restart with new values, and a species may
    then use an earlier policy (`training.pool`), which does not learn."""

    def __init__(self, config: WorldConfig, seed: int, threads: int = 1) -> None:
        self.config, self.plan, self.seed, self.threads = config, config.training, seed, threads
        self.tick, self.stage, self.share = 0, 0, 0.0
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

    def ramp(self, share: float) -> None:
        """Set the ramped values for this fraction of the training, also in worlds that are created later."""
        self.share, wanted = share, {r.key: r.at(share) for r in self.plan.ramp}
        for world in self.worlds:
            data = world.config.model_dump() if wanted else {}
            if any(real_key(data, key_of(key))[1] != value for key, value in wanted.items()):
                reconfigure(world, changed(world.config, wanted))

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
        self.ramp(self.share)

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
