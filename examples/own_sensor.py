"""A custom sensor, a compass: a function that writes its channels for all animals that have the sensor."""

import numpy as np

from ecs_eco import World
from ecs_eco.components import Position


def compass(world, table, seekers, out: np.ndarray, first: int) -> None:
    """Write the cosine and sine of the angle from the heading to north to out[:, first : first + 2], one row
    per animal."""
    north = np.pi / 2 - table[Position].heading[seekers.rows]
    out[:, first], out[:, first + 1] = np.cos(north), np.sin(north)


goose = {
    "count": 100,
    "body": {"radius": 0.3},
    "locomotion": {"speed": {"fly": 1.0}, "turn": 0.3},
    # in a file: function = "own_sensor:compass"
    "sensors": [{"kind": "custom", "function": compass, "width": 2}],
    "actions": {"speed": ["fly"], "turn": ["left", "none", "right"]},
    "always_on": ["fly"],
    "reflex": {"formulas": {"left": "compass_2 > 0.1", "right": "compass_2 < -0.1"}},
}

if __name__ == "__main__":
    world = World.from_config(
        {"format": 1, "name": "migration", "space": {"size": [100.0, 100.0]}, "species": {"goose": goose}}
    )
    for _ in range(3):
        geese = world.table("goose")
        north = np.sin(geese[Position].heading[geese.rows()]).mean()
        print(f"tick {world.tick:2}: mean northward component of the headings {north:+.2f}")
        world.run(10)
