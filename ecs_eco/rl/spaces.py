"""Observations and actions of an organism as Gymnasium spaces."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces

from ecs_eco.config.models.sensors import AnySensor, Gradient, Nearest, Rays, Smell, Touch
from ecs_eco.config.models.species import Species

MOST = 1 + 1e-6  # largest cosine, with float32 rounding


def observation_space(species: Species, dims: int) -> spaces.Box:
    """Return the Box of a species' channels, f32[channels], unbounded for sensors without limits."""
    ends = [end for sensor in species.sensors for end in _ends(sensor, dims)]
    low, high = np.array(ends, np.float32).reshape(-1, 2).T
    return spaces.Box(low, high, dtype=np.float32)


def _ends(sensor: AnySensor, dims: int) -> list[tuple[float, float]]:
    """Return the limits of each channel of a sensor."""
    channels = sensor.channels(dims)
    if isinstance(sensor, Nearest) or (isinstance(sensor, Rays) and sensor.report == "closest"):
        return [(0.0, 1.0) if name.endswith("_near") else (-MOST, MOST) for name in channels]
    if isinstance(sensor, Rays | Smell | Touch):
        return [(0.0, 1.0)] * len(channels)
    if isinstance(sensor, Gradient):
        return [(-1.0, 1.0)] * len(channels)
    return [(-np.inf, np.inf)] * len(channels)


def action_space(options: dict[str, tuple[str, ...]], low: np.ndarray, high: np.ndarray) -> spaces.Space[Any]:
    """Return the space of a species' choices: Discrete for one group of options, MultiDiscrete for
    several, a Box for continuous groups, and a Dict by group if there are both."""
    sizes = [len(names) for names in options.values() if names]
    ends = low[len(sizes) :], high[len(sizes) :]
    if len(sizes) == len(options):
        return spaces.Discrete(sizes[0]) if len(sizes) == 1 else spaces.MultiDiscrete(sizes)
    if not sizes:
        return spaces.Box(*ends, dtype=np.float32)
    return spaces.Dict(
        OrderedDict(  # Dict would sort the groups of a plain dict
            (group, spaces.Discrete(len(names)) if names else spaces.Box(low[i], high[i], (), np.float32))
            for i, (group, names) in enumerate(options.items())
        )
    )


def flattened(space: spaces.Space[Any]) -> spaces.Space[Any]:
    """Convert a Dict of options and numbers to a Box with a number from −1 to 1 for each group; return any
    other space unchanged.

    The range is divided evenly among the options of a group, or scaled to the range of a number.
    """
    return spaces.Box(-1, 1, (len(space.spaces),), np.float32) if isinstance(space, spaces.Dict) else space


def _as_groups(space: spaces.Dict, flat: np.ndarray) -> np.ndarray:
    """Convert actions in the flattened space [n, groups] to the options and numbers of the groups."""
    share = np.clip((flat + 1) / 2, 0, 1)
    groups: list[Any] = [*space.spaces.values()]
    columns = [
        np.minimum(np.floor(part * one.n), one.n - 1)
        if isinstance(one, spaces.Discrete)
        else np.clip((1 - part) * one.low + part * one.high, one.low, one.high)
        for part, one in zip(share.T, groups, strict=True)
    ]
    return np.stack(columns, 1)


def matrix(space: spaces.Space[Any], actions: Any, n: int) -> np.ndarray:
    """Return n actions as an array [n, groups]. They belong to this space, stacked as in Gymnasium, or to the
    flattened space."""
    if isinstance(space, spaces.Dict) and not isinstance(actions, Mapping):
        return _as_groups(space, np.asarray(actions, np.float64).reshape(n, len(space.spaces)))
    if isinstance(space, spaces.Dict):
        return np.stack([np.asarray(actions[group], np.float64).reshape(n) for group in space.spaces], 1)
    chosen = np.asarray(actions)
    return chosen.reshape(n, -1) if chosen.size else np.zeros((n, width(space)), np.int64)


def stacked(space: spaces.Space[Any], actions: list[Any]) -> Any:
    """Stack single actions in the form that `matrix` accepts."""
    if isinstance(space, spaces.Dict):
        return {group: [action[group] for action in actions] for group in space.spaces}
    return actions


def width(space: spaces.Space[Any]) -> int:
    """Return the number of groups in a space."""
    if isinstance(space, spaces.Dict):
        return len(space.spaces)
    return int(np.prod(space.shape or (), dtype=int)) or 1
