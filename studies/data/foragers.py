"""The food and the hunters of foragers.toml.

In each tick, an animal finds a red and a blue place, one to its left and one to its right, and goes to one of
them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field

from ecs_eco import System, component, f32, i8
from ecs_eco.components import Metabolism, Nervous
from ecs_eco.engine.random import USER, draw_many

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

Probability = Annotated[float, Field(ge=0, le=1)]
CHANGE, LEFT, ACCIDENT, NATIVE = (USER + (i << 8) for i in range(1, 5))


@component
class Food:
    """The places of one animal: +1 stands for red, −1 for blue."""

    left: i8 = 1  # color of the place to its left
    native: i8 = 1  # color of the place that was good for it at birth
    good: i8 = 1  # color of the place that is good for it now
    visited: i8 = 1  # color of the place where it was last
    worth: f32 = 0.0  # of that place, from 0 to 1


class Forage(System):
    """Each animal goes to the place that it chooses; animals of a species share the energy `supply`.

    A forager gets its share at the good place and nothing at the other. The good place changes color with
    probability `within` per tick. At birth, it has the color that it had at the mother's birth or, with
    probability `between`, the other color. If there are hunters, a place is instead worth the proportion of
    hunters that wait at the other place, and to a hunter, the proportion of foragers that come to it. An animal
    has a fatal accident with probability `accident` per tick.
    """

    needs = (Food, Nervous, Metabolism)
    phase = "interact"
    acts = ("side",)
    world: SpatialWorld

    def __init__(
        self, supply: float, within: Probability, between: Probability, accident: Probability
    ) -> None:
        self.supply, self.within, self.between, self.accident = supply, within, between, accident

    def start(self, world: SpatialWorld) -> None:
        """Give newborns their good place."""
        world.on_birth.append(self.born)
        self.world = world

    def born(self, table: Table, rows: np.ndarray, mothers: np.ndarray, _: np.ndarray) -> None:
        """Give newborns in rows i64[k] the good place of their mothers, u64[k], or the other."""
        if Food in table:
            food, living = table[Food], table.by_uid()
            at = living[np.minimum(np.searchsorted(table.uid[living], mothers), living.size - 1)]
            native = np.where(table.uid[at] == mothers, food.native[at], 1)
            changes = draw_many(self.world.key, table.uid[rows], NATIVE) < self.between
            food.native[rows] = food.good[rows] = np.where(changes, -native, native)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Feed one species, and change the colors of its places."""
        rows, food, m = table.rows(), table[Food], table[Metabolism]
        if not rows.size:
            return
        uid, right = table.uid[rows], table.species.nerves.doing(table, "right")[rows]
        food.visited[rows] = np.where(right, -food.left[rows], food.left[rows])
        food.worth[rows] = self.worth(table, world, rows)
        before = m.energy[rows]
        gain = food.worth[rows] * np.float32(self.supply * world.dt / rows.size)
        m.energy[rows] = np.minimum(before + gain, np.float32(table.species.metabolism.energy_max))
        m.taken[rows] += m.energy[rows] - before
        changes = draw_many(world.key, uid, CHANGE) < self.within
        food.good[rows] = np.where(changes, -food.good[rows], food.good[rows])
        food.left[rows] = np.where(draw_many(world.key, uid, LEFT) < 0.5, 1, -1)
        table.cause[rows[draw_many(world.key, uid, ACCIDENT) < self.accident]] = world.cause("accident")

    def worth(self, table: Table, world: SpatialWorld, rows: np.ndarray) -> np.ndarray:
        """Return what the places are worth that animals in rows i64[n] visit."""
        color, hunters = table[Food].visited[rows], world.table("hunter")
        if not hunters.n:
            return np.asarray(color == table[Food].good[rows])
        hunted = table.name != "hunter"
        others = hunters if hunted else world.table("forager")
        red = float((others[Food].visited[others.rows()] > 0).mean()) if others.n else 0.5
        there = np.where(color > 0, red, 1 - red)
        return 1 - there if hunted else there


class Taste(System):
    """An animal is rewarded with the worth of the place where it was."""

    needs = (Food, Nervous)
    phase = "feel"

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Set the rewards of one species."""
        rows = table.rows()
        table[Nervous].reward[rows] = table[Food].worth[rows]
