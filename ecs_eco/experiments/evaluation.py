"""How trained policies do beside random ones, in the worlds of their training."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.config import WorldConfig, for_training
from ecs_eco.ecosystem import World
from ecs_eco.experiments.pretraining import pretrain, save

SEEDS = 3
TICKS = 300  # of each run, at most
MEASURES = {
    "happiness": "mean happiness",
    "intake": "intake per animal and second",
    "deaths": "deaths per animal and second",
}


def against_random(
    config: WorldConfig, policies: Path | str, seed: int, ticks: int = TICKS, seeds: int = SEEDS
) -> dict[str, Any]:
    """Run trained and random policies, neither learning, in `seeds` worlds of the training. Returns species →
    measure → {"trained": [mean, low, high], "random": …, "difference": …} (95 %, Student's t over seeds,
    which arms share)."""
    found = {
        arm: [_measured(config, chosen, seed + 1 + k, ticks) for k in range(seeds)]
        for arm, chosen in (("trained", str(policies)), ("random", "random"))
    }
    out: dict[str, Any] = {}
    for s in found["trained"][0]:
        out[s] = {}
        for word in MEASURES:
            trained, random = (
                np.array([run[s][word] for run in found[arm]]) for arm in ("trained", "random")
            )
            out[s][word] = {
                "trained": _interval(trained),
                "random": _interval(random),
                "difference": _interval(trained - random),
            }
    return out


def train_and_evaluate(
    config: WorldConfig, seed: int, ticks: int, out: Path, progress: Callable[[int, int], None] | None = None
) -> dict[str, Any]:
    """Train policies into a folder; return what `pretrain` does, with "against_random"."""
    config._code.pass_on()
    result = pretrain(config, seed, ticks, out, progress)
    result["against_random"] = against_random(config, out, seed, min(ticks, TICKS))
    save(result, out)
    return result


def _measured(config: WorldConfig, policies: str, seed: int, ticks: int) -> dict[str, dict[str, float]]:
    world = World.from_config(for_training(config), seed=seed, policies=policies, training=True, learn=False)
    world.run(ticks)
    names = world.recorder.names
    table = world.series().select(["n", "taken_in", "deaths", "happiness_mean"])
    series = {k: np.asarray(v, float).reshape(-1, len(names)) for k, v in table.to_pydict().items()}
    out = {}
    for i, name in enumerate(names):
        if world.tables[name].species.nerves is not None and world.tables[name].species.nerves.policy:
            lived = max(float(series["n"][:, i].sum()) * config.dt, 1e-12)
            out[name] = {
                "happiness": float(series["happiness_mean"][:, i].mean()),
                "intake": float(series["taken_in"][:, i].sum()) / lived,
                "deaths": float(series["deaths"][:, i].sum()) / lived,
            }
    return out


def _interval(values: np.ndarray) -> list[float | None]:
    from scipy.stats import t

    mean, n = float(values.mean()), len(values)
    half = float(t.ppf(0.975, n - 1) * values.std(ddof=1) / np.sqrt(n)) if n > 1 else None
    return [mean, None, None] if half is None else [mean, mean - half, mean + half]
