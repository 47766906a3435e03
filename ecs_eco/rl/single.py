"""One organism of a species as an Env of Gymnasium; the others live as they do without it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.nervous.external import Sensed
from ecs_eco.rl import spaces
from ecs_eco.rl.arena import Arena, Shown
from ecs_eco.rl.registration import needed

try:
    from gymnasium import Env
except ModuleNotFoundError as error:
    raise needed(error.name or "gymnasium") from None


class Body(Shown, Env):
    """The life of one organism, from wherever it is to its death, which is termination.

    `reset` with a seed begins a new world; without one the next life is that of another member of the same
    world, until this is `max_cycles` ticks old, or the species extinct. Which one is drawn by chance.
    """

    def __init__(self, arena: Arena, render_mode: str | None = None, flat: bool = False) -> None:
        self.arena, self.render_mode = arena, render_mode
        self.metadata = {"render_modes": ["rgb_array"], "render_fps": 20}
        self.channels, self.options = arena.channels, arena.options
        self.observation_space, self.action_space = arena.observation_space, arena.actions_as(flat)
        self.uid = 0  # of the organism; 0: none lives
        self._sensed: Sensed | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Return what an organism senses, f32[channels], and its uid in the info."""
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
        """Let a tick pass."""
        if not self.uid:
            raise RuntimeError("the organism is dead, or none has been chosen: reset() first")
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
    world: Any,
    species: str,
    *,
    max_cycles: int | None = None,
    render_mode: str | None = None,
    flat: bool = False,
    **build: Any,
) -> Body:
    """Return one organism of a species as an Env of Gymnasium, as `gymnasium.make("ecs_eco/Deer-v0")` does.

    `world` is what World.from_config takes, `build` its other arguments; or a living World, of which each
    episode begins with a copy. `max_cycles`: ticks of a world; absent: those of the world file. `flat`: where
    options and numbers are chosen, the action is a Box (`ecs_eco.rl.spaces.flattened`), not a Dict.
    """
    return Body(Arena(world, species, max_cycles, True, render_mode, build), render_mode, flat)
