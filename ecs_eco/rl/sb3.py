"""Slots as a Stable-Baselines3 VecEnv."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.rl.vector import Slots

try:
    from stable_baselines3.common.vec_env import VecEnv
except ModuleNotFoundError as error:
    raise ModuleNotFoundError(
        f"{error.name} is not installed: pip install stable-baselines3", name=error.name
    ) from None


class SlotsVecEnv(VecEnv):
    """A Stable-Baselines3 VecEnv over slots. Slots cannot be empty, so use fewer slots than there are
    organisms.

    Stable-Baselines3 does not support a Dict of actions: if there are both options and continuous actions,
    they are combined in a Box (see `ecs_eco.rl.spaces.flattened`).
    """

    def __init__(self, envs: Slots) -> None:
        self.envs, self._actions = envs, np.zeros(0)
        self.render_mode = envs.render_mode
        super().__init__(envs.num_envs, envs.single_observation_space, envs.arena.actions_as(flat=True))

    def reset(self) -> np.ndarray:
        """Start a new world; return observations f32[n, channels]."""
        seed = self._seeds[0]
        self._reset_seeds()
        observations: np.ndarray = self.envs.reset(seed=seed)[0]
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        """Store the actions for the next step."""
        self._actions = actions

    def step_wait(self) -> Any:
        """Run a tick."""
        x, reward, terminated, truncated, infos = self.envs.step(self._actions)
        told: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for slot in np.flatnonzero(terminated | truncated):
            told[slot] = {
                "terminal_observation": infos["final_obs"][slot],
                "TimeLimit.truncated": bool(truncated[slot]),
            }
        return x, reward.astype(np.float32), terminated | truncated, told

    def close(self) -> None:
        """Release the world."""
        self.envs.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute once for each slot."""
        return [getattr(self.envs, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute."""
        setattr(self.envs, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """Call a method."""
        return [getattr(self.envs, method_name)(*args, **kwargs)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Return False for each slot, because no slot is wrapped."""
        return [False] * len(list(self._get_indices(indices)))

    def get_images(self) -> list[Any]:
        """Return one picture of the world."""
        return [self.envs.render()]


def vec_env(envs: Slots) -> SlotsVecEnv:
    """Return slots as a Stable-Baselines3 VecEnv.

    Parameters
    ----------
    envs : Slots
        As returned by `slots`; use fewer slots than there are organisms, because a VecEnv cannot have empty
        ones.

    Returns
    -------
    SlotsVecEnv
        For `stable_baselines3.PPO("MlpPolicy", vec_env(slots(…)))`.
    """
    return SlotsVecEnv(envs)
