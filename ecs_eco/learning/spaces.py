"""Gymnasium's spaces in the form that a brain uses: rows of numbers in, choices or numbers out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.learning.continuous import CONTINUOUS, in_units

if TYPE_CHECKING:
    from gymnasium.vector import VectorEnv
    from numpy.typing import ArrayLike


def as_vector(envs: Any) -> VectorEnv:
    """Return a vector of environments; a single environment becomes a vector of one. Raises TypeError for
    anything else."""
    if hasattr(envs, "num_envs"):
        return envs
    if not all(hasattr(envs, name) for name in ("reset", "step", "observation_space", "action_space")):
        raise TypeError(
            f"envs = {envs!r}: expected a Gymnasium environment, or a vector of them, such as "
            'gymnasium.make_vec("CartPole-v1", num_envs=8)'
        )
    from gymnasium.vector import SyncVectorEnv

    return SyncVectorEnv([lambda: envs])


def resets_in_same_step(envs: VectorEnv) -> bool:
    """Return whether environments reset in the same step in which an episode ends. Raises ValueError if they
    do not reset."""
    mode = getattr(envs.metadata.get("autoreset_mode"), "name", None)
    if mode not in ("NEXT_STEP", "SAME_STEP"):
        raise ValueError(f"metadata['autoreset_mode'] of {envs} is {mode}: expected NEXT_STEP or SAME_STEP")
    return mode == "SAME_STEP"


@dataclass(frozen=True)
class Observations:
    """An environment's observations as rows of numbers: arrays are unchanged; integers, which take `counts`
    values starting at `first`, are one-hot encoded."""

    shape: tuple[int, ...]
    counts: np.ndarray | None = None
    first: np.ndarray | None = None

    @classmethod
    def of(cls, envs: VectorEnv) -> Observations:
        """Return the observations of vector environments. Raises ValueError if the space is not an array."""
        space: Any = envs.single_observation_space
        kind = type(space).__name__
        if kind in ("Box", "MultiBinary"):
            return cls(tuple(space.shape))
        if kind == "Discrete":
            return cls((), np.array([space.n]), np.array([space.start]))
        if kind == "MultiDiscrete" and space.nvec.ndim == 1:
            return cls(tuple(space.shape), np.asarray(space.nvec), np.asarray(space.start))
        raise ValueError(
            f"observation space {space}: expected Box, Discrete, MultiDiscrete or MultiBinary; "
            "gymnasium.wrappers.FlattenObservation(env) converts others to a Box"
        )

    def rows(self, observations: ArrayLike) -> np.ndarray:
        """Return n observations as f32[n, k]."""
        seen = np.asarray(observations)
        if self.counts is None or self.first is None:
            return np.asarray(seen, np.float32).reshape(len(seen), -1)
        places = seen.reshape(len(seen), -1) - self.first + np.cumsum([0, *self.counts[:-1]])
        out = np.zeros((len(seen), int(self.counts.sum())), np.float32)
        np.put_along_axis(out, places.astype(np.int64), 1.0, axis=1)
        return out


@dataclass(frozen=True)
class Actions:
    """Actions in the form that a brain outputs: choices counted from `first` [G], or numbers from `low` to
    `high` [K]."""

    groups: tuple[int, ...]
    shape: tuple[int, ...]
    dtype: Any
    first: np.ndarray | None = None
    low: np.ndarray | None = None
    high: np.ndarray | None = None

    @classmethod
    def of(cls, envs: VectorEnv) -> Actions:
        """Return the actions of vector environments. Raises ValueError if a brain cannot act in the space."""
        space: Any = envs.single_action_space
        kind = type(space).__name__
        if kind == "Discrete":
            return cls((int(space.n),), (), space.dtype, np.array([space.start]))
        if kind == "MultiDiscrete" and space.nvec.ndim == 1:
            return cls(tuple(int(n) for n in space.nvec), space.shape, space.dtype, np.asarray(space.start))
        if (
            kind == "Box"
            and len(space.shape) == 1
            and space.is_bounded()
            and np.issubdtype(space.dtype, np.floating)
        ):
            return cls(
                (CONTINUOUS,) * space.shape[0], space.shape, space.dtype, low=space.low, high=space.high
            )
        raise ValueError(
            f"action space {space}: expected Discrete, or MultiDiscrete or a bounded Box of "
            "numbers with one axis"
        )

    def sent(self, choice: np.ndarray, numbers: np.ndarray) -> np.ndarray:
        """Return choices int[n, G] or numbers f32[n, K] in the form that the environments expect."""
        if self.low is None or self.high is None:
            return (choice + self.first).reshape(len(choice), *self.shape)
        return in_units(numbers, self.low, self.high).astype(self.dtype).reshape(len(numbers), *self.shape)
