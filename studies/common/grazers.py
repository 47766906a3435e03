"""Deer with hand-written policies: they graze, and either run from wolves or ignore them."""

from __future__ import annotations

import numpy as np

# channels of deer in the world predator-prey, in order
CHANNELS = (
    "energy",
    "grass_forward",
    "grass_left",
    "grass_near",
    "deer_forward",
    "deer_left",
    "deer_near",
    "wolf_forward",
    "wolf_left",
    "wolf_near",
    "grass_smell_1",
    "grass_smell_2",
    "wolf_smell_1",
    "wolf_smell_2",
)
STILL, WALK, RUN = range(3)
LEFT, AHEAD, RIGHT = range(3)
SATED = 0.85  # energy above which deer in that world do not eat
ASIDE = 0.3  # sideways component of a neighbor's direction vector above which an animal turns


def graze(x: np.ndarray, uid: np.ndarray) -> np.ndarray:
    """Walk to the nearest visible grass while hungry, or follow its smell if none is in sight; otherwise
    stand: i64[n, 2]."""
    seen = _of(x)
    forward, left, near = seen["grass_forward"], seen["grass_left"], seen["grass_near"]
    turn = _towards(forward, left)
    lost = near <= 0
    stronger = seen["grass_smell_1"] - seen["grass_smell_2"]
    scent = np.where(stronger > 0, LEFT, np.where(stronger < 0, RIGHT, AHEAD))
    turn = np.where(lost, np.where(uid % 5 == 0, scent, AHEAD), turn)
    speed = np.where(lost | (forward > 0), WALK, STILL)
    speed = np.where(seen["energy"] < SATED, speed, STILL)
    return np.stack([speed, turn], 1)


def graze_and_flee(x: np.ndarray, uid: np.ndarray) -> np.ndarray:
    """Act as in `graze`, but turn and run from a visible wolf: i64[n, 2]."""
    seen, out = _of(x), graze(x, uid)
    away = _towards(-seen["wolf_forward"], -seen["wolf_left"])
    return np.where((seen["wolf_near"] > 0)[:, None], np.stack([np.full(len(x), RUN), away], 1), out)


def _of(x: np.ndarray) -> dict[str, np.ndarray]:
    return {name: x[:, i] for i, name in enumerate(CHANNELS)}


def _towards(forward: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Turn toward a direction; turn left if it is directly behind."""
    turn = np.where(left > ASIDE, LEFT, np.where(left < -ASIDE, RIGHT, AHEAD))
    return np.where((forward < 0) & (turn == AHEAD), LEFT, turn)
