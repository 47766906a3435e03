"""A disease that spreads from the ill to the well beside them."""

import numpy as np

from ecs_eco import System, component, f32, u8
from ecs_eco.components import Position
from ecs_eco.engine.random import USER, draw_many


@component
class Health:
    """How someone is."""

    state: u8 = 0  # 0 well, 1 ill, 2 immune
    left: f32 = 0.0  # [s] of illness


class Disease(System):
    """The well fall ill beside the ill, who become immune."""

    needs = (Health, Position)

    def __init__(self, beta: float = 0.1, radius: float = 2.0, lasts: float = 30.0):
        self.beta, self.radius, self.lasts = beta, radius, lasts

    def update(self, table, world):
        health, rows = table[Health], table.by_uid()
        one, other, _ = world.pairs(table, table, self.radius)
        beside = np.bincount(one[health.state[other] == 1], minlength=table.capacity)[rows]
        luck = draw_many(world.key, table.uid[rows], USER)
        caught = rows[(health.state[rows] == 0) & (luck < 1 - (1 - self.beta) ** beside)]
        if world.tick == 0:
            caught = rows[:5]
        health.left[rows] -= np.float32(world.dt)
        health.state[rows[(health.state[rows] == 1) & (health.left[rows] <= 0)]] = 2
        health.state[caught], health.left[caught] = 1, self.lasts


def prevalence(world):
    people = world.table("people")
    return np.mean(people[Health].state[people.rows()] == 1)
