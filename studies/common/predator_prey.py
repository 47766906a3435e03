"""Code shared by the predator-prey studies: world identity, runs until the first extinction, and numbers over
time."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.policies import without_policies

SPECIES = ("grass", "deer", "wolf")
PPO = {
    "horizon": 64,
    "learning_rate": 1e-3,
    "discount": 0.98,
    "gae_lambda": 0.95,
    "epochs": 3,
    "anneal": 3000,
    "entropy_coef": 0.01,
}
# the world of studies with frozen policies: wolves that live on less, and PPO as in pre-training
FROZEN: dict[str, Any] = {
    "species.deer.policy.learn": False,
    "species.wolf.policy.learn": False,
    "species.wolf.diet.0.gain": 0.46,
    "species.wolf.metabolism.basal": 0.003,
    "species.wolf.reproduction.rate": 0.007,
    "species.wolf.reproduction.spacing": 8.5,
    "species.deer.ppo": PPO | {"minibatch_size": 8192},
    "species.wolf.ppo": PPO | {"minibatch_size": 2048},
    "training.set": {
        "space.size": [180.0, 180.0],
        "species.grass.count": 1800,
        "species.deer.count": 350,
        "species.wolf.count": 100,
        "species.grass.reproduction.rate": 0.0,
        "species.grass.reproduction.seed_rain": 0.02,
    },
}
# the wolves of studies registered before the second registration of `lifelong`
SPARSE_WOLVES: dict[str, Any] = {
    "species.wolf.diet.0.gain": 0.55,
    "species.wolf.reproduction.rate": 0.007,
    "species.wolf.reproduction.spacing": 10.75,
}
SHIPPED = Path(__file__).parents[2] / "ecs_eco" / "worlds" / "predator_prey"


def frozen(changes: Mapping[str, Any] | None = None) -> Any:
    """Return the shipped world with FROZEN and then `changes` applied."""
    from ecs_eco.config import load

    return load("predator-prey", FROZEN | dict(changes or {}))


def identity(policies: bool = True) -> dict[str, str | None]:
    """Return hashes of the world with frozen policies and of its bundled policies, so that changing the world
    invalidates the results."""
    files = {s: SHIPPED / f"{s}.safetensors" for s in SPECIES[1:]} if policies else {}
    hashes = {
        s: hashlib.sha256(f.read_bytes()).hexdigest()[:16] if f.is_file() else None for s, f in files.items()
    }
    return {"world": hashlib.sha256(str(without_policies(frozen())).encode()).hexdigest()[:16], **hashes}


def live(
    config: Any, seed: int, policies: Any, ticks: int, learn: bool | None = None, chunk: int = 250
) -> Any:
    """Run a world for `ticks` ticks or until deer or wolves go extinct (checked every `chunk` ticks); species
    that learn have a constant learning rate."""
    from ecs_eco import World
    from ecs_eco.config.loading import changed

    config = changed(config, {f"species.{s}.ppo.anneal": 0 for s in ("deer", "wolf")})
    world = World.from_config(config, seed=seed, policies=policies, learn=learn)
    while world.tick < ticks and all(world.tables[s].n for s in ("deer", "wolf")):
        world.run(min(chunk, ticks - world.tick))
    return world


def numbers(world: Any) -> np.ndarray:
    """Return the numbers of grass, deer and wolves by tick: i64[ticks, 3]."""
    names = world.recorder.names  # the series' rows are in order
    n = np.asarray(world.series()["n"], np.int64).reshape(-1, len(names))
    return n[:, [names.index(name) for name in SPECIES]]


def packed(n: np.ndarray, block: int) -> dict[str, str]:
    """Return means over blocks of ticks as text, one line of JSON per species."""
    kept = n[: len(n) // block * block].reshape(-1, block, n.shape[1]).mean(1)
    return {name: " ".join(f"{v:.0f}" for v in kept[:, i]) for i, name in enumerate(SPECIES)}


def unpacked(lines: Mapping[str, str], block: int) -> Any:
    """Return the series that `packed` wrote, for ecs_eco.analysis."""
    from ecs_eco.analysis.runs import Series

    n = np.array([[float(v) for v in lines[name].split()] for name in SPECIES]).T
    return Series(np.arange(len(n)) * block, SPECIES, {"n": n})


def first_extinction(n: np.ndarray) -> tuple[int, str | None]:
    """Return the tick of the first extinction of deer or wolves, and the species; if both survive, the run's
    length and None."""
    gone = [
        (int(t[0]), name) for i, name in enumerate(SPECIES) if i and len(t := np.flatnonzero(n[:, i] == 0))
    ]
    return min(gone) if gone else (len(n), None)
