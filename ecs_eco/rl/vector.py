"""A species as a Gymnasium VectorEnv: n slots, each of which controls one member."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.config.loading import WorldSource
from ecs_eco.ecosystem import World
from ecs_eco.engine import random
from ecs_eco.engine.arguments import whole_number
from ecs_eco.engine.uids import matched
from ecs_eco.nervous.external import Sensed
from ecs_eco.rl import spaces
from ecs_eco.rl.arena import Arena, Shown
from ecs_eco.rl.registration import needed

try:
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space
except ModuleNotFoundError as error:
    raise needed(error.name or "gymnasium") from None

FILL = random.LOT + (4 << 8)  # purpose of the random draws that fill free slots
Step = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]


class Slots(Shown, VectorEnv):
    """Members of a species as a Gymnasium VectorEnv: each of n slots controls one organism until it dies.

    Notes
    -----
    Death terminates a slot's episode; `final_obs` in the infos contains the last reading. In the same step,
    the free slot receives a living member without a slot, drawn at random. If there is no such member, the
    slot stays empty: it reads zeros, and `mask` in the infos is False. Members without a slot follow the
    species' own policy, or act at random if there is none. After `max_cycles` ticks, all slots are truncated;
    then, or when the species is extinct, a new world starts in the same step.

    Examples
    --------
    >>> from ecs_eco.rl import slots
    >>> envs = slots("predator-prey", "deer", 4, max_cycles=50)
    >>> observations, infos = envs.reset(seed=1)
    >>> envs.step(envs.action_space.sample())[1].shape
    (4,)
    """

    def __init__(self, arena: Arena, n: int, render_mode: str | None = None, flat: bool = False) -> None:
        self.arena, self.num_envs, self.render_mode = arena, whole_number("n", n, 1), render_mode
        self.autoreset_mode = AutoresetMode.SAME_STEP  # as TorchRL requires
        self.metadata = {"autoreset_mode": self.autoreset_mode, "render_modes": ["rgb_array"]}
        self.channels, self.options = arena.channels, arena.options
        self.single_observation_space, self.single_action_space = (
            arena.observation_space,
            arena.actions_as(flat),
        )
        self.observation_space = batch_space(self.single_observation_space, n)
        self.action_space = batch_space(self.single_action_space, n)
        self.uid = np.zeros(n, np.uint64)  # uid of each slot's organism; 0 if the slot is empty
        self._at = np.zeros(n, np.int64)  # the organisms' indices among all sensing organisms

    @property
    def mask(self) -> np.ndarray:
        """The slots that have an organism: bool[n]."""
        return self.uid > 0

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> Any:
        """Start a new world.

        Parameters
        ----------
        seed : int or sequence of int, optional
            Only the first seed of a sequence is used.
        options : dict, optional
            Ignored.

        Returns
        -------
        observations : array of float32, shape (n, channels)
        infos : dict
            The slots' "mask" and "uid".
        """
        seed = seed[0] if isinstance(seed, list | tuple | np.ndarray) else seed
        super().reset(seed=seed)
        return self._anew(seed), self._infos()

    def step(self, actions: Any) -> Step:
        """Advance the world by one tick.

        Parameters
        ----------
        actions : array, shape (n, groups)
            Actions of empty slots are ignored.

        Returns
        -------
        observations : array of float32, shape (n, channels)
        rewards : array of float64, shape (n,)
        terminations, truncations : array of bool, shape (n,)
        infos : dict
        """
        n, filled = self.num_envs, self.mask
        chosen = spaces.matrix(self.arena.action_space, actions, n)
        sensed = self.arena.step(chosen[filled], self.uid[filled])
        reward, final = np.zeros(n), np.zeros((n, len(self.channels)), np.float32)
        here = self._find(sensed.uid)
        reward[here] = sensed.reward[self._at[here]]
        ended = filled & ~here
        place = _places(sensed.dead, self.uid[ended])
        reward[ended], final[ended] = sensed.dead_reward[place], sensed.dead_x[place]
        truncated = here & self.arena.late
        final[truncated] = sensed.x[self._at[truncated]]
        cause = np.full(n, "", object)
        cause[ended] = np.asarray(sensed.dead_cause, object)[place]
        over = ended | truncated
        last = {"uid": self.uid.astype(np.int64), "mask": over, "cause": cause}
        self.uid[over] = 0
        x = self._anew() if self.arena.late or not len(sensed.uid) else self._filled(sensed)
        return x, reward, ended, truncated, self._infos(over, final, last)

    def close_extras(self, **_: object) -> None:
        """Release the world."""
        self.arena.close()

    def _anew(self, seed: int | None = None) -> np.ndarray:
        self.uid[:] = 0
        return self._filled(self.arena.begin_alive(seed))

    def _find(self, uids: np.ndarray) -> np.ndarray:
        """Find the slots' organisms among uids u64[k]; return whether each slot's organism is there, bool[n]."""
        if not len(uids):
            return np.zeros(self.num_envs, np.bool_)
        self._at = _places(uids, self.uid)
        there: np.ndarray = (uids[self._at] == self.uid) & self.mask
        return there

    def _filled(self, sensed: Sensed) -> np.ndarray:
        """Assign organisms without a slot to free slots; return all observations, f32[n, channels]."""
        free = np.flatnonzero(self.uid == 0)
        if len(free) and len(sensed.uid) > self.num_envs - len(free):
            others = np.setdiff1d(sensed.uid, self.uid)
            if len(others) > len(free):
                key = self.arena.opened().world.key
                others = np.sort(others[random.by_lot(key, others, FILL)[: len(free)]])
            self.uid[free[: len(others)]] = others
        here = self._find(sensed.uid)
        x = np.zeros((self.num_envs, len(self.channels)), np.float32)
        x[here] = sensed.x[self._at[here]]
        return x

    def _infos(
        self, over: np.ndarray | None = None, final: Any = None, last: dict[str, np.ndarray] | None = None
    ) -> dict[str, Any]:
        """Return the infos of a step in Gymnasium's form, including the `final` observations f32[n, channels]
        and `last` infos [n] of slots whose episodes are `over`, bool[n]."""
        infos: dict[str, Any] = {"mask": self.mask, "uid": self.uid.astype(np.int64)}
        if over is not None and last is not None and over.any():
            observations = np.full(self.num_envs, None, object)
            for slot in np.flatnonzero(over).tolist():
                observations[slot] = final[slot]
            told = last | {f"_{name}": over for name in last}
            infos |= {"final_obs": observations, "_final_obs": over, "final_info": told, "_final_info": over}
        return infos


def _places(uids: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return the indices i64[k] of the wanted uids u64[k] among uids u64[n]; arbitrary for missing ones."""
    order = np.argsort(uids)
    at: np.ndarray = order[matched(uids[order], wanted)[0]]
    return at


def slots(
    world: World | WorldSource,
    species: str,
    n: int | None = None,
    *,
    num_envs: int | None = None,
    max_cycles: int | None = None,
    max_episode_steps: int | None = None,
    render_mode: str | None = None,
    flat: bool = False,
    **build: Any,
) -> Slots:
    """Return n organisms of a species as a Gymnasium VectorEnv.

    Parameters
    ----------
    world : str, Path, Mapping, WorldConfig or World
        Anything that `World.from_config` accepts, or a live world; each episode starts with a copy of it,
        with other random draws, except in the first episode if it is given no seed.
    species : str
    n, num_envs : int
        Number of slots; pass only one of the two. `gymnasium.make_vec` passes `num_envs`.
    max_cycles, max_episode_steps : int, optional
        Ticks per episode; default: the world file's `ticks`.
    render_mode : {"rgb_array"}, optional
    flat : bool, default False
        Whether to use a Box instead of a Dict if a species has both options and continuous actions.
    **build
        Other arguments of `World.from_config`, such as `policies` and `threads`.

    Returns
    -------
    Slots

    Raises
    ------
    ConfigError
        If the species is unknown, makes no decisions or has no happiness (its reward).

    Examples
    --------
    >>> from ecs_eco.rl import slots
    >>> envs = slots("predator-prey", "deer", 16, max_cycles=50)
    >>> observations, infos = envs.reset(seed=1)
    >>> observations, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())
    >>> rewards.shape
    (16,)
    >>> envs.close()
    """
    n = num_envs if n is None else n
    if n is None:
        raise TypeError("slots: n is missing; expected a whole number of at least 1")
    cycles = max_episode_steps if max_cycles is None else max_cycles
    return Slots(Arena(world, species, cycles, True, render_mode, build), n, render_mode, flat)
