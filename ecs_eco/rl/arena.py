"""The common base of all environments: one world per episode, with external control of a species."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.components import Body, Position
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.loading import WorldSource
from ecs_eco.ecosystem import World
from ecs_eco.engine.arguments import seed_number, whole_number
from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest
from ecs_eco.nervous.external import External, Sensed
from ecs_eco.rl import spaces

RENDERED = ("rgb_array",)
GRID = 16  # cells along each side of the world in `state`
WIDTH = 480  # [px] longer side of a picture
PAPER = (247, 246, 242)


class Arena:
    """Worlds in which a program controls a species.

    `world` and `build` are the arguments of `World.from_config`. If `world` is a live World, each episode
    begins with a copy of it: the first, if it is given no seed, is unchanged; all others have a different
    seed. Learning within the world is off unless `learn` turns it on.
    """

    def __init__(
        self,
        world: World | WorldSource,
        species: str,
        cycles: int | None,
        partial: bool,
        render_mode: str | None,
        build: dict[str, Any],
    ) -> None:
        self.species, self.partial, self.build = species, partial, {"learn": False, "record": False} | build
        self.origin = world if isinstance(world, World) else None
        if self.origin is not None and build:
            raise TypeError(f"{', '.join(build)}: a live world is already built")
        self.config: WorldConfig = (
            world.config
            if isinstance(world, World)
            else world
            if isinstance(world, WorldConfig)
            else load(world)
        )
        _check(self.config, species, render_mode)
        self.cycles = self.config.ticks if cycles is None else whole_number("max_cycles", cycles, 1)
        self.world: World | None = None
        self.door: External | None = None
        self.ended = 0  # the tick at which the episode's time is up
        self.seed, self.episode = self.config.seed, -1
        self._spaces()

    def _spaces(self) -> None:
        """Create the spaces from a world without organisms."""
        door = External(self._made(self.config.seed, populate=False), self.species, self.partial)
        self.channels, self.options = door.channels, door.options
        self.observation_space = spaces.observation_space(self.config.species[self.species], self.config.dims)
        self.action_space = spaces.action_space(door.options, door.low, door.high)

    def begin(self, seed: int | None = None) -> Sensed:
        """Begin an episode in a new world, with `seed` or the next seed in the current sequence."""
        if seed is not None:
            self.seed, self.episode = seed_number(seed), -1
        first, self.episode = self.episode < 0, self.episode + 1
        self.close()
        made = self.seed if first else int(np.random.Philox(key=[self.seed, self.episode]).random_raw() >> 1)
        if self.origin is None:
            self.world = self._made(made)
        else:
            self.world = self.origin.copy() if first and seed is None else self.origin.fork(made)
        self.door = External(self.world, self.species, self.partial)
        self.ended = self.world.tick + self.cycles
        return self.door.observe()

    def begin_alive(self, seed: int | None = None) -> Sensed:
        """Begin an episode. Raises ConfigError if its world has no members of the species."""
        sensed = self.begin(seed)
        if not len(sensed.uid):
            raise ConfigError(
                [
                    Problem(
                        ("species", self.species),
                        "has no members at the start of an episode",
                        allowed="a world with at least one member",
                        source="ecs_eco.rl",
                    )
                ]
            )
        return sensed

    def step(self, actions: np.ndarray, uid: np.ndarray | None = None) -> Sensed:
        """Run a tick, up to the point where the next actions are needed."""
        door = self.opened()
        door.act(actions, uid)
        return door.observe()

    def actions_as(self, flat: bool) -> Any:
        """Return the action space, as a Box if it is a Dict and `flat` is set."""
        return spaces.flattened(self.action_space) if flat else self.action_space

    def opened(self) -> External:
        """Return the external control. Raises RuntimeError before the first episode."""
        if self.door is None:
            raise RuntimeError(f"the environment of {self.species!r} has not begun; call reset() first")
        return self.door

    @property
    def late(self) -> bool:
        """Whether the episode's time is up."""
        return self.world is not None and self.world.tick >= self.ended

    def close(self) -> None:
        """Release the world."""
        self.world = self.door = None

    def state(self) -> np.ndarray:
        """Return the number of organisms of each species in each grid cell: f32[species, GRID, GRID]."""
        world = self.opened().world
        out = np.zeros((len(self.config.species), GRID, GRID), np.float32)
        for i, name in enumerate(self.config.species):
            table = world.tables[name]
            rows = table.rows()
            x, y = (
                np.clip((getattr(table[Position], axis)[rows] / length * GRID).astype(int), 0, GRID - 1)
                for axis, length in zip("xy", world.space.size, strict=False)
            )
            np.add.at(out[i], (y, x), 1)
        return out

    def _made(self, seed: int, **how: Any) -> World:
        return World.from_config(self.config, seed=seed, **(self.build | how))


class Shown:
    """Rendering and saving, shared by all environments of an arena."""

    arena: Arena
    render_mode: str | None

    def render(self) -> Any:
        """Return a picture of the world, u8[height, width, 3]; None without a `render_mode`."""
        return None if self.render_mode is None else draw(self.arena.opened().world)

    def save(self, path: str | Path) -> Path:
        """Write a checkpoint at the end of the current tick, which falls within the next step."""
        return Path(self.arena.opened().save(path))


def _check(config: WorldConfig, species: str, render_mode: str | None) -> None:
    """Raise ConfigError for a species that cannot be an environment, and for an unknown render mode."""
    problems = []
    if species not in config.species:
        known = [name for name, one in config.species.items() if one.policy.kind != "none"]
        problems.append(
            Problem(
                ("species",), "no such species", species, listed(known), nearest(species, known), "ecs_eco.rl"
            )
        )
    elif config.species[species].happiness is None:
        problems.append(
            Problem(
                ("species", species, "happiness"),
                "the species has no reward",
                allowed="a happiness network; the reward is its change",
                source="ecs_eco.rl",
            )
        )
    if render_mode is not None and render_mode not in RENDERED:
        problems.append(
            Problem(
                ("render_mode",),
                "unknown render mode",
                render_mode,
                f"{listed(RENDERED)}, or None",
                nearest(render_mode, RENDERED),
                "ecs_eco.rl",
            )
        )
    if problems:
        raise ConfigError(problems)


def draw(world: World) -> np.ndarray:
    """Draw the world from above, or a volume from the side: u8[height, width, 3]."""
    across, up = ("x", "z") if world.space.volume else ("x", "y")
    extent = world.space.size[0], world.space.size[2 if world.space.volume else 1]
    scale = WIDTH / max(extent)
    shape = max(1, round(extent[1] * scale)), max(1, round(extent[0] * scale))
    picture = np.full((*shape, 3), PAPER, np.uint8)
    for table in world.tables.values():
        if Position in table and table.n:
            rows = table.rows()
            place = table[Position]
            _discs(
                picture,
                getattr(place, across)[rows] * scale,
                shape[0] - 1 - getattr(place, up)[rows] * scale,
                table[Body].radius[rows] * scale,
                tuple(bytes.fromhex((table.species.color or "#808080").lstrip("#"))),
            )
    return picture


def _discs(
    picture: np.ndarray, x: np.ndarray, y: np.ndarray, radius: np.ndarray, colour: tuple[int, ...]
) -> None:
    """Draw discs at positions f32[n] [px], each at least one pixel wide."""
    for size in np.unique(np.clip(np.round(radius), 0, 40)).astype(int):
        here = np.clip(np.round(radius), 0, 40) == size
        dy, dx = np.mgrid[-size : size + 1, -size : size + 1]
        inside = dx * dx + dy * dy <= (size + 0.25) ** 2
        columns = (x[here, None] + dx[inside]).astype(int).clip(0, picture.shape[1] - 1)
        rows = (y[here, None] + dy[inside]).astype(int).clip(0, picture.shape[0] - 1)
        picture[rows, columns] = colour
