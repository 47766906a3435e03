"""A disease that spreads between neighbors: the feature, component, systems and reporter for
epidemic.toml."""

from pathlib import Path

import numpy as np

from ecs_eco import System, World, component, f32, u8
from ecs_eco.components import Position
from ecs_eco.config import FREE, Count, Feature, NonNegative, Positive, Section, Share, about, quantity
from ecs_eco.engine.random import USER, draw_many
from ecs_eco.genomes.own_values import own_value
from ecs_eco.space.geometry import back_into

WELL, ILL, IMMUNE = 0, 1, 2


@component
class Health:
    """One organism's health."""

    state: u8 = 0  # well, ill or immune
    left: f32 = 0.0  # [s] of illness


class Walk(System):
    """Move all members one step in a random direction, wrapping around a torus or stopping at a wall."""

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
        table.version += 1  # positions have changed, so the neighbor index is rebuilt at its next use


class Infect(System):
    """Infect healthy members near infected ones; infected members recover and become immune."""

    needs = (Health, Position)

    def update(self, table, world) -> None:
        disease = table.species.disease
        health, p, rows = table[Health], table[Position], table.by_uid()
        if world.tick == 0:
            self.infect(health, rows[: disease.first], disease.lasts)
        ill = rows[health.state[rows] == ILL]
        near = world.within(table, np.column_stack([p.x[ill], p.y[ill]]), disease.radius).others
        beta = np.broadcast_to(own_value(table, "disease.beta", disease.beta), table.high)[rows]
        risk = 1 - (1 - beta) ** (world.dt * np.bincount(near, minlength=table.capacity)[rows])
        health.left[ill] -= np.float32(world.dt)
        health.state[ill[health.left[ill] <= 0]] = IMMUNE
        luck = draw_many(world.key, table.uid[rows], USER + (1 << 8))
        self.infect(health, rows[(health.state[rows] == WELL) & (luck < risk)], disease.lasts)

    def infect(self, health, rows, lasts) -> None:
        health.state[rows], health.left[rows] = ILL, lasts


class Disease(Section, change=FREE):
    """A species' disease parameters."""

    beta: Share = quantity("probability of infection per infected neighbor", "1/s", own=True)
    radius: Positive = quantity("distance over which it spreads", "m", 2.0)
    lasts: NonNegative = quantity("duration of the infection", "s", 30.0)
    first: Count = quantity("members infected at the start", "1", 3)


class Epidemic(Feature):
    """Members of a species with `disease` infect each other."""

    disease: Disease | None = about("the disease; default: no disease", None)
    systems = (Infect,)

    @staticmethod
    def brings(species):
        if species.disease is not None:
            yield None, Health


def prevalence(world, state: int = ILL):
    """Return the share of people in a given state."""
    people = world.table("people")
    return np.mean(people[Health].state[people.rows()] == state)


if __name__ == "__main__":
    for beta in (0.02, 0.1):
        world = World.from_config(Path(__file__).with_name("epidemic.toml"), trust=True)
        world.intervene({"kind": "set", "set": {"species.people.disease.beta": beta}})
        ill = world.run(200).series()["prevalence"].to_numpy()
        print(
            f"beta {beta}: at most {ill.max():.0%} ill, at tick {ill.argmax()}; "
            f"finally {world.measure('immune'):.0%} immune"
        )
