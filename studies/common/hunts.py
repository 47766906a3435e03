"""Wolves approach deer whose hand-written policies make them walk or run away from a visible wolf."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

MODULE = "studies.common.hunts"
STILL, WALK, RUN = range(3)
LEFT, AHEAD, RIGHT = range(3)
ASIDE = 0.3  # sideways component of a neighbor's direction vector above which an animal turns
SPACING, FROM = 40.0, 5.0  # [m] between pairs; the wolf's initial distance, equal to its range of sight
STORES = {"deer": 0.7, "wolf": 0.5}  # initial energy
DEER = {"forward": 7, "left": 8, "near": 9}  # deer channels that sense wolves
WOLF = {"forward": 1, "left": 2, "near": 3}  # wolf channels that sense deer


def walk_away(x: np.ndarray, uid: np.ndarray) -> np.ndarray:
    """Stand still, but walk away from a visible wolf: i64[n, 2]."""
    return _away(x, WALK)


def run_away(x: np.ndarray, uid: np.ndarray) -> np.ndarray:
    """Stand still, but run away from a visible wolf: i64[n, 2]."""
    return _away(x, RUN)


def chase(x: np.ndarray, uid: np.ndarray) -> np.ndarray:
    """Run to a visible deer, otherwise walk straight ahead: i64[n, 2]."""
    seen = x[:, WOLF["near"]] > 0
    turn = np.where(seen, _towards(x[:, WOLF["forward"]], x[:, WOLF["left"]]), AHEAD)
    return np.stack([np.where(seen, RUN, WALK), turn], 1)


def approaches(changes: Mapping[str, Any], deer: str, seed: int, side: int, ticks: int) -> dict[str, float]:
    """Send a wolf at each of side² deer, with all pairs far apart, in a modified predator-prey world. `deer`
    names the function in this module that decides for them. Return the share of deer alive after the given
    number of ticks and the mean happiness, which is energy for living deer and −1 for dead deer."""
    from ecs_eco import World
    from ecs_eco.components import Metabolism
    from ecs_eco.config import load

    world = World.from_config(load(_arena(changes, deer, side), trust=True), seed=seed, record=False)
    _meet(world, side)
    world.run(ticks)
    table = world.tables["deer"]
    energy = table[Metabolism].energy[table.rows()]
    return {"survival": table.n / side**2, "happiness": float(energy.sum() - (side**2 - table.n)) / side**2}


def _arena(changes: Mapping[str, Any], deer: str, side: int) -> dict[str, Any]:
    """Return the world without grass or births, with as many wolves as deer."""
    from studies.common.policies import without_policies
    from studies.common.predator_prey import frozen

    content = without_policies(frozen(changes))
    content["code"], content["space"]["size"] = [MODULE], [side * SPACING] * 2
    for name, function in (("deer", deer), ("wolf", "chase")):
        content["species"][name].pop("ppo", None)
        content["species"][name] |= {
            "count": side**2,
            "reproduction": None,
            "policy": {"kind": "function", "function": f"{MODULE}:{function}"},
        }
    grass = content["species"]["grass"]
    grass["count"], grass["reproduction"]["seed_rain"] = 0, 0.0
    return content


def _meet(world: Any, side: int) -> None:
    """Place deer on a grid with random headings, and a wolf FROM meters from each deer, facing it."""
    from ecs_eco.components import Metabolism, Position

    rng, n = np.random.default_rng(world.seed), side**2
    way, facing = rng.uniform(-np.pi, np.pi, (2, n))
    x, y = (SPACING * (g.ravel() + 0.5) for g in np.mgrid[:side, :side])
    for name, far, heading in (("deer", 0.0, facing), ("wolf", FROM, way + np.pi)):
        table = world.tables[name]
        rows, p = table.by_uid(), table[Position]
        p.x[rows], p.y[rows] = x + far * np.cos(way), y + far * np.sin(way)
        p.heading[rows], table[Metabolism].energy[rows] = heading, STORES[name]
        table.version += 1


def _away(x: np.ndarray, speed: int) -> np.ndarray:
    """Turn away from a visible wolf and move at this speed; otherwise stand."""
    seen = x[:, DEER["near"]] > 0
    turn = np.where(seen, _towards(-x[:, DEER["forward"]], -x[:, DEER["left"]]), AHEAD)
    return np.stack([np.where(seen, speed, STILL), turn], 1)


def _towards(forward: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Turn toward a direction; turn left if it is directly behind."""
    turn = np.where(left > ASIDE, LEFT, np.where(left < -ASIDE, RIGHT, AHEAD))
    return np.where((forward < 0) & (turn == AHEAD), LEFT, turn)
