"""A species as a PettingZoo ParallelEnv: its members are agents, which are born and die."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np

from ecs_eco.config.loading import WorldSource
from ecs_eco.ecosystem import World
from ecs_eco.engine.arguments import whole_number
from ecs_eco.engine.errors import ConfigError, Problem, listed
from ecs_eco.nervous.external import Sensed
from ecs_eco.rl import spaces
from ecs_eco.rl.arena import GRID, Arena, Shown
from ecs_eco.rl.registration import needed

try:
    from gymnasium.spaces import Box
    from pettingzoo import ParallelEnv
except ModuleNotFoundError as error:
    raise needed(error.name or "pettingzoo") from None

Agent = Any  # a uid or, with a pool, a name
Step = tuple[
    dict[Agent, np.ndarray],
    dict[Agent, float],
    dict[Agent, bool],
    dict[Agent, bool],
    dict[Agent, dict[str, Any]],
]


class Parallel(Shown, ParallelEnv):
    """All members of a species as a PettingZoo ParallelEnv, in which each is an agent named by its uid.

    Notes
    -----
    A newborn appears in all five dicts of the step in which it first senses, with a reward of 0. An agent
    that dies has one last entry: its last reading and reward, `terminated`, and the cause of death in `info`.
    After `max_cycles` ticks, all agents are truncated; `agents` is empty once the species is extinct.

    Examples
    --------
    >>> from ecs_eco.rl import parallel_env
    >>> env = parallel_env("predator-prey", "wolf", max_cycles=50)
    >>> observations, infos = env.reset(seed=1)
    >>> wolf = env.agents[0]
    >>> env.observation_space(wolf).shape == observations[wolf].shape
    True
    >>> step = env.step({agent: env.action_space(agent).sample() for agent in env.agents})
    >>> env.state().shape
    (3, 16, 16)
    >>> env.close()
    """

    def __init__(self, arena: Arena, pool: int | None, render_mode: str | None) -> None:
        self.arena, self.render_mode, self.pool = arena, render_mode, pool
        self.metadata = {
            "name": f"{arena.config.name}_{arena.species}",
            "render_modes": ["rgb_array"],
            "is_parallelizable": True,
        }
        self.agents: list[Agent] = []
        self.channels, self.options = arena.channels, arena.options
        self._actions: dict[Agent, Any] = {}
        self._named: dict[int, str] = {}  # uid → name, with a pool
        self._uids = np.zeros(0, np.uint64)  # uids of the agents, in the same order
        self._order = np.zeros(0, np.int64)  # their indices among all sensing organisms
        n = len(arena.config.species)
        self.state_space = Box(0, np.inf, (n, GRID, GRID), np.float32)
        if pool is not None:
            pool = whole_number("pool", pool, 1)
            self.possible_agents = [f"{arena.species}_{i}" for i in range(pool)]

    @property
    def max_cycles(self) -> int:
        """Ticks per episode."""
        return self.arena.cycles

    @max_cycles.setter
    def max_cycles(self, cycles: int) -> None:
        self.arena.cycles = whole_number("max_cycles", cycles, 1)

    def observation_space(self, agent: Agent) -> Any:
        """Return the observation space: a Box with a number for each of `channels`.

        Parameters
        ----------
        agent : int or str

        Returns
        -------
        gymnasium.spaces.Box
        """
        return self.arena.observation_space

    def action_space(self, agent: Agent) -> Any:
        """Return the action space, with a number for each group in `options`.

        Parameters
        ----------
        agent : int or str

        Returns
        -------
        gymnasium.spaces.Space
            Each agent has its own space, which you can seed; by default, its seed is derived from the
            episode's.
        """
        if agent not in self._actions:
            space = self._actions[agent] = deepcopy(self.arena.action_space)
            number = agent if self.pool is None else int(agent.rpartition("_")[2])
            space.seed((self.arena.seed * 1_000_003 + number) % 2**31)
        return self._actions[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Start an episode in a new world.

        Parameters
        ----------
        seed : int, optional
        options : dict, optional
            Ignored.

        Returns
        -------
        observations : dict of agent to array of float32, shape (channels,)
        infos : dict of agent to dict
        """
        sensed = self.arena.begin(seed)
        self._named, self._actions = {}, {}
        x, late = self._see(sensed, {})
        if late:
            raise ConfigError(
                [
                    Problem(
                        ("pool",),
                        "is smaller than the initial population",
                        self.pool,
                        f"at least {len(sensed.uid)}, plus names for newborns",
                        source="parallel_env",
                    )
                ]
            )
        return dict(zip(self.agents, x, strict=True)), self._infos(())

    def step(self, actions: dict[Agent, Any]) -> Step:
        """Advance the world by one tick.

        Parameters
        ----------
        actions : dict of agent to action
            One action for each of `agents`.

        Returns
        -------
        observations, rewards, terminations, truncations, infos : dict by agent

        Raises
        ------
        ConfigError
            If an action is missing or invalid, or belongs to an agent that is not alive.
        """
        if not self.agents:
            return {}, {}, {}, {}, {}
        chosen = self._chosen(actions)
        before = dict(zip(self._uids.tolist(), self.agents, strict=True))
        sensed = self.arena.step(chosen)
        dead = [before[uid] for uid in sensed.dead.tolist()]
        x, late = self._see(sensed, before)
        seen = [*self.agents, *dead]
        rewards = [*sensed.reward[self._order].tolist(), *sensed.dead_reward.tolist()]
        alive = len(self.agents)
        out = (
            dict(zip(seen, [*x, *sensed.dead_x], strict=True)),
            dict(zip(seen, rewards, strict=True)),
            dict(zip(seen, [False] * alive + [True] * len(dead), strict=True)),
            dict(zip(seen, [late] * alive + [False] * len(dead), strict=True)),
            self._infos(zip(dead, sensed.dead_cause, strict=True)),
        )
        for agent in dead:
            self._actions.pop(agent, None)
        if late:
            self.agents = []
        return out

    def state(self) -> np.ndarray:
        """Return the number of organisms of each species in each grid cell.

        Returns
        -------
        array of float32, shape (species, 16, 16)
        """
        return self.arena.state()

    def close(self) -> None:
        """Release the world.

        Returns
        -------
        None
        """
        self.arena.close()
        self.agents = []

    def _see(self, sensed: Sensed, before: dict[int, Agent]) -> tuple[np.ndarray, bool]:
        """Make all sensing organisms agents, in order of uid. Return their observations f32[n, channels] and
        whether the episode ends here: its time is up, or the pool has no name left. If so, omit newborns."""
        order = np.argsort(sensed.uid)
        uids = sensed.uid[order].tolist()
        if self.pool is not None:
            for uid in uids:
                if uid not in self._named and len(self._named) < self.pool:
                    self._named[uid] = f"{self.arena.species}_{len(self._named)}"
        names = {uid: uid for uid in uids} if self.pool is None else self._named
        late = self.arena.late or not names.keys() >= set(uids)
        if late:
            order = order[[uid in before for uid in uids]]
        self._order, self._uids = order, sensed.uid[order]
        self.agents = [names[uid] for uid in self._uids.tolist()]
        return sensed.x[order], late

    def _chosen(self, actions: dict[Agent, Any]) -> np.ndarray:
        """Return the actions of all agents in the order that the control expects, [n, groups]. Raises
        ConfigError."""
        known = set(self.agents)
        if actions.keys() != known:
            missing, strange = sorted(known - actions.keys()), [a for a in actions if a not in known]
            name = self.arena.species
            problems = [
                Problem(
                    (name, "actions"),
                    f"{fault} ({len(agents)} such)",
                    listed(map(str, agents)),
                    f"exactly one action for each of the {len(known)} in `agents`",
                    source="step",
                )
                for fault, agents in (
                    ("no action", missing),
                    ("not a current agent: dead or never born", strange),
                )
                if agents
            ]
            raise ConfigError(problems)
        space, n = self.arena.action_space, len(self.agents)
        try:
            rows = spaces.matrix(space, spaces.stacked(space, [actions[a] for a in self.agents]), n)
        except (ValueError, TypeError, KeyError) as error:
            raise ConfigError(
                [
                    Problem(
                        (self.arena.species, "actions"),
                        f"not {n} actions: {error}",
                        allowed=f"for each agent, an action in {space}",
                        source="step",
                    )
                ]
            ) from None
        out = np.empty_like(rows)
        out[self._order] = rows
        return out

    def _infos(self, dead: Any) -> dict[Agent, dict[str, Any]]:
        uids = zip(self.agents, self._uids.tolist(), strict=True)
        return {agent: {"uid": uid} for agent, uid in uids} | {
            agent: {"cause": cause} for agent, cause in dead
        }


def parallel_env(
    world: World | WorldSource,
    species: str,
    pool: int | None = None,
    *,
    max_cycles: int | None = None,
    render_mode: str | None = None,
    **build: Any,
) -> Parallel:
    """Return a species as a PettingZoo ParallelEnv, in which each member is an agent.

    Parameters
    ----------
    world : str, Path, Mapping, WorldConfig or World
        Anything that `World.from_config` accepts, or a live world; each episode starts with a copy of it,
        with other random draws, except in the first episode if it is given no seed.
    species : str
    pool : int, optional
        Number of agent names, for libraries that need `possible_agents`: names are assigned in order of
        birth, and the episode is truncated when no name is left. Default: agents are uids.
    max_cycles : int, optional
        Ticks per episode; default: the world file's `ticks`.
    render_mode : {"rgb_array"}, optional
    **build
        Other arguments of `World.from_config`, such as `policies` and `threads`.

    Returns
    -------
    Parallel

    Raises
    ------
    ConfigError
        If the species is unknown, makes no decisions or has no happiness (its reward).

    Examples
    --------
    >>> from ecs_eco.rl import parallel_env
    >>> env = parallel_env("predator-prey", "wolf", max_cycles=50)
    >>> observations, infos = env.reset(seed=1)
    >>> actions = {agent: env.action_space(agent).sample() for agent in env.agents}
    >>> rewards = env.step(actions)[1]
    >>> len(rewards) >= 250
    True
    >>> env.close()
    """
    return Parallel(Arena(world, species, max_cycles, False, render_mode, build), pool, render_mode)
