"""Build a world without a world file, from tables, systems and spawns: an epidemic among random walkers."""

import numpy as np

from ecs_eco import System, World, component, f32, u8
from ecs_eco.components import Body, Position
from ecs_eco.engine.random import USER, draw_many

WELL, ILL, IMMUNE = 0, 1, 2


@component
class Health:
    """One person's health."""

    state: u8 = 0  # well, ill, immune
    left: f32 = 0.0  # [s] of illness


class Walk(System):
    """Move all people one step in a random direction."""

    needs = (Position,)
    phase = "move"

    def update(self, table, world) -> None:
        rows, p = table.rows(), table[Position]
        angle = draw_many(world.key, table.uid[rows], USER) * np.float32(2 * np.pi)
        p.x[rows] = (p.x[rows] + np.cos(angle)) % world.space.lengths[0]
        p.y[rows] = (p.y[rows] + np.sin(angle)) % world.space.lengths[1]
        table.version += 1  # positions have changed, so the neighbor index is rebuilt at its next use


class Infect(System):
    """Infect people within 2 m of an ill person; ill people become immune after 60 s."""

    needs = (Health, Position)

    def update(self, table, world) -> None:
        rows, health = table.rows(), table[Health]
        one, other, _ = world.pairs(table, table, 2.0)
        caught = one[(health.state[one] == WELL) & (health.state[other] == ILL)]
        ill = rows[health.state[rows] == ILL]
        health.left[ill] -= world.dt
        health.state[ill[health.left[ill] <= 0]] = IMMUNE
        health.state[caught], health.left[caught] = ILL, 60.0


if __name__ == "__main__":
    world = World((60.0, 60.0), seed=1)
    people = world.add_table("people", Position, Body, Health)
    world.add_system(Walk())
    world.add_system(Infect())
    place = np.random.default_rng(1).uniform(0, 60, (300, 2))
    for x, y in place:
        world.spawn("people", Position(x=x, y=y))
    world.spawn("people", Position(x=30.0, y=30.0), Health(state=ILL, left=60.0), n=3)
    for _ in range(5):
        world.run(50)
        state = people[Health].state[people.rows()]
        print(
            f"tick {world.tick:3}: {(state == WELL).sum()} well, {(state == ILL).sum()} ill, "
            f"{(state == IMMUNE).sum()} immune"
        )
