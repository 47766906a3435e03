"""Pre-training: policies learn from random weights while respawn holds the numbers constant (the paper's protocol)."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.config import WorldConfig, load

CURVES = ("intake", "deaths", "happiness")


def pretrain(config: Any, seed: int | None = None, ticks: int | None = None, out: str | Path | None = None,
             progress: Callable[[int, int], None] | None = None, *, threads: int = 1, points: int = 30) -> dict[str, Any]:
    """Train the policies of all species of a world that have one; return the curves, and the networks under "policies".

    Per species and point of the curve: intake per animal and second, deaths per animal and second, mean happiness.
    `out` receives <species>.safetensors and training.json.
    """
    from ecs_eco.world import World

    config = config if isinstance(config, WorldConfig) else load(config)
    ticks = config.training.ticks if ticks is None else ticks
    begin = time.perf_counter()
    world = World.from_config(config, seed=seed, policies="untrained", threads=threads, training=True, learn=True)
    last: dict[str, list[dict[str, np.ndarray]]] = {}
    every = max(1, ticks // points)
    for done in range(0, ticks, every):
        world.run(min(every, ticks - done))
        if progress is not None:
            progress(world.tick, ticks)
        if world.tick > (1 - config.training.average) * ticks or world.tick == ticks:
            for name, brain in brains(world).items():
                last.setdefault(name, []).append(brain.state())
    policies = {name: mean_weights(states) for name, states in last.items()}
    result = {"world": config.name, "config_hash": config.config_hash, "seed": world.seed, "ticks": ticks,
              "seconds": time.perf_counter() - begin, "curves": curves(world, every), "policies": policies,
              "reports": {name: _last_report(t) for name, t in world.tables.items() if _learns(t)}}
    if out is not None:
        save(result, Path(out))
    return result


def save(result: dict[str, Any], out: Path) -> None:
    """Write the policies as safetensors and everything else as training.json."""
    from safetensors.numpy import save_file

    from ecs_eco.record.folder import write_json

    out.mkdir(parents=True, exist_ok=True)
    for name, weights in result["policies"].items():
        save_file({k: np.ascontiguousarray(v) for k, v in weights.items()}, out / f"{name}.safetensors")
    write_json(out / "training.json", {k: v for k, v in result.items() if k != "policies"})


def mean_weights(states: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return the average of several states of one network: steadier than the last of them (Polyak & Juditsky 1992)."""
    return {k: np.asarray(np.mean([s[k] for s in states], axis=0, dtype=np.float64), np.float32) for k in states[0]}


def brains(world: Any) -> dict[str, Any]:
    """Return the networks of all species that have one, by name."""
    found = {name: t.traits["nerves"].brain for name, t in world.tables.items() if "nerves" in t.traits}
    return {name: brain for name, brain in found.items() if brain is not None}


def _learns(table: Any) -> bool:
    return "nerves" in table.traits and table.traits["nerves"].learning


def _last_report(table: Any) -> dict[str, float | None]:
    """Return what the last update said; nothing where there was none, None for what it could not say."""
    reports = table.traits["nerves"].reports
    return {k: v if np.isfinite(v) else None for k, v in reports[-1].items()} if reports else {}


def curves(world: Any, every: int) -> dict[str, dict[str, Any]]:
    """Return what the animals of each species did, averaged over blocks of `every` ticks."""
    series = world.series().to_pydict()
    s = len(world.recorder.names)
    out: dict[str, dict[str, Any]] = {}
    for i, name in enumerate(world.recorder.names):
        column = {k: np.asarray(series[k][i::s], float) for k in ("tick", "n", "taken_in", "deaths", "happiness_mean")}
        blocks = [slice(a, a + every) for a in range(0, len(column["n"]), every)]
        alive = np.array([max(column["n"][b].sum(), 1) for b in blocks]) * world.dt
        out[name] = {"tick": [int(column["tick"][b][-1]) + 1 for b in blocks],
                     "intake": [float(v) for v in np.array([column["taken_in"][b].sum() for b in blocks]) / alive],
                     "deaths": [float(v) for v in np.array([column["deaths"][b].sum() for b in blocks]) / alive],
                     "happiness": [float(column["happiness_mean"][b].mean()) for b in blocks]}
    return out
