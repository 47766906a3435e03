"""A disease that spreads by nearness: component, systems with parameters and a reporter of epidemic.toml."""

from pathlib import Path

import numpy as np

from ecs_eco import System, World, component, f32, u8
from ecs_eco.components import Position
from ecs_eco.engine.random import USER, draw_many
from ecs_eco.space.geometry import back_into

WELL, ILL, IMMUNE = 0, 1, 2


@component
class Health:
    """How someone is."""

    state: u8 = 0  # well, ill or immune
    left: f32 = 0.0  # [s] of illness


class Walk(System):
    """Everyone takes steps in random directions, around the torus or to the wall."""

    needs = (Position,)
    phase = "move"

    def __init__(self, speed: float = 1.0) -> None:  # [m/s]
        self.speed = speed

    def update(self, table, world) -> None:
        rows, p, space = table.rows(), table[Position], world.space
        angle = 2 * np.pi * draw_many(world.key, table.uid[rows], USER)
        for axis, way in enumerate((np.cos(angle), np.sin(angle))):
            place = (p.x, p.y)[axis]
            step = (self.speed * world.dt * way).astype(np.float32)
            place[rows] = back_into(place[rows] + step, space.lengths[axis], space.wrap[axis])
        table.version += 1  # places have changed: the index of neighbours is made anew when it is asked for


class Disease(System):
    """The well fall ill beside the ill, with chance beta in each second and from each of them; the ill
    become immune."""

    needs = (Health, Position)

    def __init__(self, beta: float = 0.1, radius: float = 2.0, lasts: float = 30.0, first: int = 3) -> None:
        self.beta, self.radius, self.lasts, self.first = beta, radius, lasts, first

    def update(self, table, world) -> None:
        health, p, rows = table[Health], table[Position], table.by_uid()
        if world.tick == 0:
            self.infect(health, rows[: self.first])
        ill = rows[health.state[rows] == ILL]
        near = world.within(table, np.column_stack([p.x[ill], p.y[ill]]), self.radius).others
        risk = 1 - (1 - self.beta) ** (world.dt * np.bincount(near, minlength=table.capacity)[rows])
        health.left[ill] -= np.float32(world.dt)
        health.state[ill[health.left[ill] <= 0]] = IMMUNE
        luck = draw_many(world.key, table.uid[rows], USER + (1 << 8))
        self.infect(health, rows[(health.state[rows] == WELL) & (luck < risk)])

    def infect(self, health, rows) -> None:
        health.state[rows], health.left[rows] = ILL, self.lasts


def prevalence(world, state: int = ILL):
    """Share of the people in a state."""
    people = world.table("people")
    return np.mean(people[Health].state[people.rows()] == state)


if __name__ == "__main__":
    for beta in (0.02, 0.1):
        world = World.from_config(Path(__file__).with_name("epidemic.toml"), trust=True)
        world.intervene({"kind": "set", "set": {"systems.Disease.beta": beta}})
        ill = world.run(200).series()["prevalence"].to_numpy()
        print(
            f"beta {beta}: at most {ill.max():.0%} ill, at tick {ill.argmax()}; "
            f"in the end {world.report('immune'):.0%} immune"
        )
