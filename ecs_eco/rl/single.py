"""One organism of a species as a Gymnasium Env; all other organisms behave as usual."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.config.loading import WorldSource
from ecs_eco.ecosystem import World
from ecs_eco.nervous.external import Sensed
from ecs_eco.rl import spaces
from ecs_eco.rl.arena import Arena, Shown
from ecs_eco.rl.registration import needed

try:
    from gymnasium import Env
except ModuleNotFoundError as error:
    raise needed(error.name or "gymnasium") from None


class Body(Shown, Env):
    """One organism as a Gymnasium Env; its death terminates the episode.

    `reset` with a seed starts a new world. Without a seed, the next episode follows another member of the
    same world, drawn at random; once the world is `max_cycles` ticks old or the species is extinct, a new
    world starts.

    Examples
    --------
    >>> from ecs_eco.rl import body
    >>> env = body("predator-prey", "deer", max_cycles=50)
    >>> observation, info = env.reset(seed=1)
    >>> env.step(env.action_space.sample())[0].shape == observation.shape
    True
    """

    def __init__(self, arena: Arena, render_mode: str | None = None, flat: bool = False) -> None:
        self.arena, self.render_mode = arena, render_mode
        self.metadata = {"render_modes": ["rgb_array"], "render_fps": 20}
        self.channels, self.options = arena.channels, arena.options
        self.observation_space, self.action_space = arena.observation_space, arena.actions_as(flat)
        self.uid = 0  # uid of the organism; 0 if no organism is alive
        self._sensed: Sensed | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Start an episode with one organism.

        Parameters
        ----------
        seed : int, optional
            Starts a new world.
        options : dict, optional
            Ignored.

        Returns
        -------
        observation : array of float32, shape (channels,)
        info : dict
            The organism's "uid".
        """
        super().reset(seed=seed)
        sensed = self._sensed
        if seed is not None or sensed is None or self.arena.late or not len(sensed.uid):
            sensed = self.arena.begin_alive(seed)
        self._sensed = sensed
        place = int(self.np_random.integers(len(sensed.uid)))
        at = int(np.argsort(sensed.uid)[place])
        self.uid = int(sensed.uid[at])
        return sensed.x[at].copy(), {"uid": self.uid}

    def step(self, action: Any) -> Any:
        """Advance the world by one tick.

        Parameters
        ----------
        action : array or dict
            An element of `action_space`.

        Returns
        -------
        observation : array of float32, shape (channels,)
        reward : float
            Change of happiness.
        terminated : bool
            Whether the organism died; `info` then contains the "cause".
        truncated : bool
            Whether the world has reached `max_cycles` ticks.
        info : dict

        Raises
        ------
        RuntimeError
            If the organism is dead or no organism has been chosen; call `reset` first.
        """
        if not self.uid:
            raise RuntimeError("the organism is dead, or none has been chosen; call reset() first")
        space = self.arena.action_space
        batch = {group: [value] for group, value in action.items()} if isinstance(action, dict) else [action]
        sensed = self._sensed = self.arena.step(spaces.matrix(space, batch, 1), np.array([self.uid], "u8"))
        at = np.flatnonzero(sensed.uid == self.uid)
        if at.size:
            truncated = self.arena.late
            return (sensed.x[at[0]].copy(), float(sensed.reward[at[0]]), False, truncated, {"uid": self.uid})
        i = int(np.flatnonzero(sensed.dead == self.uid)[0])
        info = {"uid": self.uid, "cause": sensed.dead_cause[i]}
        self.uid = 0
        return sensed.dead_x[i].copy(), float(sensed.dead_reward[i]), True, False, info

    def close(self) -> None:
        """Leave the world."""
        self.arena.close()
        self.uid, self._sensed = 0, None


def body(
    world: World | WorldSource,
    species: str,
    *,
    max_cycles: int | None = None,
    render_mode: str | None = None,
    flat: bool = False,
    **build: Any,
) -> Body:
    """Return one organism of a species as a Gymnasium Env, as `gymnasium.make("ecs_eco/Deer-v0")` does.

    Parameters
    ----------
    world : str, Path, Mapping, WorldConfig or World
        Anything that `World.from_config` accepts, or a live world; each episode starts with a copy of it,
        with other random draws, except in the first episode if it is given no seed.
    species : str
    max_cycles : int, optional
        Ticks per world; default: the world file's `ticks`.
    render_mode : {"rgb_array"}, optional
    flat : bool, default False
        Whether to use a Box instead of a Dict if a species has both options and continuous actions.
    **build
        Other arguments of `World.from_config`.

    Returns
    -------
    Body

    Raises
    ------
    ConfigError
        If the species is unknown, makes no decisions or has no happiness (its reward).

    Examples
    --------
    >>> from ecs_eco.rl import body
    >>> env = body("predator-prey", "deer", max_cycles=50)
    >>> observation, info = env.reset(seed=1)
    >>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    >>> env.close()
    """
    return Body(Arena(world, species, max_cycles, True, render_mode, build), render_mode, flat)
