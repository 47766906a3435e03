"""Pre-training and its evaluation: policies learn from random weights while respawning keeps numbers constant."""

import time
from collections.abc import Callable
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
from ecs_eco.engine.arguments import called_with, seed_number, whole_number
from ecs_eco.lab.training_worlds import TrainingWorlds, counts_of, curves
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
        for world in training_worlds.worlds:
            ramp(world, config, done / ticks)
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


def over_time(training_worlds: TrainingWorlds) -> dict[str, Any]:
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


def ramp(world: World, config: WorldConfig, share: float) -> None:
    """Set a training world's ramped values for this fraction of the training."""
    wanted = {r.key: r.at(share) for r in config.training.ramp}
    data = world.config.model_dump() if wanted else {}
    if any(real_key(data, key_of(key))[1] != value for key, value in wanted.items()):
        reconfigure(world, changed(world.config, wanted))


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
