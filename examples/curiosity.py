"""Curiosity: a custom system rewards animals for visiting places where they have not been recently, so they
learn to explore."""

import numpy as np

from ecs_eco import System, World, component, i64
from ecs_eco.components import Nervous, Position

SIZE, CELLS = 16.0, 8  # [m], cells along a side
HOLD = 60  # ticks after which an animal forgets a cell


@component
class Visits:
    """Tick of an animal's last visit to each grid cell."""

    last: i64[CELLS * CELLS] = -HOLD - 1  # tick


class Curiosity(System):
    """Reward an animal for entering a cell that it has forgotten or never visited."""

    needs = (Nervous, Visits)
    phase = "feel"  # runs after the shipped system, which sets the reward to the change in happiness

    def __init__(self, bonus: float) -> None:
        self.bonus = np.float32(bonus)

    def update(self, table, world) -> None:
        rows, place, last = table.rows(), table[Position], table[Visits].last
        x, y = ((axis[rows] * (CELLS / SIZE)).astype(int) % CELLS for axis in (place.x, place.y))
        cell = x * CELLS + y
        table[Nervous].reward[rows] += self.bonus * (world.tick - last[rows, cell] > HOLD)
        last[rows, cell] = world.tick


CAT = {
    "count": 40,
    "body": {"radius": 0.2},
    "components": [Visits],
    "metabolism": {"basal": 0.0},
    "sensors": [{"kind": "own", "property": "energy"}],
    "locomotion": {"speed": {"sit": 0.0, "go": 0.5}, "turn": 0.5},
    "actions": {"speed": ["sit", "go"], "turn": ["left", "none", "right"]},
    "happiness": {"formula": "energy", "minimum": 0.0},  # constant here, so the bonus is the only reward
    "policy": {"kind": "shared", "hidden": [16], "learn": True},
    "ppo": {"horizon": 32, "learning_rate": 0.003},
}
GROUND = {"format": 1, "name": "ground", "space": {"size": [SIZE, SIZE]}, "species": {"cat": CAT}}

if __name__ == "__main__":
    for bonus in (0.0, 1.0):
        world = World.from_config(GROUND, seed=1, policies="untrained", systems=[Curiosity(bonus)]).run(480)
        cats = world.table("cat")
        recent = cats[Visits].last[cats.rows()] > world.tick - 100
        reward = world.recorder.learning_series()["reward"].to_pylist()
        print(
            f"bonus {bonus}: {recent.sum(axis=1).mean():.1f} cells visited in the last 100 ticks; "
            f"reward per decision {reward[0]:.2f} at first, {reward[-1]:.2f} at the end"
        )
