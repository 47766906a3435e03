"""A policy written by hand: a function of what all deer sense, and of their uids.

The same function decides within the world, `policy = { kind = "function", … }`, and beside it, through the
door that `world.external` opens: arrays out, arrays in, once a tick. Both make the same world.
"""

from pathlib import Path

import numpy as np
import pyarrow.compute as pc

from ecs_eco import World
from ecs_eco.config import load

GRAZING = Path(__file__).parent / "grazing.toml"
CHANNELS = ("energy", "grass_forward", "grass_left", "grass_near", "deer_forward", "deer_left", "deer_near")
STILL, WALK, RUN = range(3)
LEFT, AHEAD, RIGHT = range(3)


def act(x: np.ndarray, uid: np.ndarray) -> np.ndarray:
    """Turn to the nearest grass and go there; where there is none, walk in a wide bow, each to its side."""
    forward, left, near = (x[:, CHANNELS.index(f"grass_{way}")] for way in ("forward", "left", "near"))
    turn = np.where(left > 0.3, LEFT, np.where(left < -0.3, RIGHT, AHEAD))
    turn = np.where((forward < 0) & (turn == AHEAD), LEFT, turn)
    speed = np.where(forward > 0.5, RUN, STILL)  # turn first
    lost, side = near == 0, np.where(uid % 2, LEFT, RIGHT)
    wander = np.where(uid % 7 == 0, side, AHEAD)
    return np.stack([np.where(lost, WALK, speed), np.where(lost, wander, turn)], 1)


def meals(world: World, ticks: int = 200) -> float:
    """Energy that a deer takes in, in a hundred ticks."""
    world.run(ticks)
    deer = world.series().filter(pc.field("species") == "deer")
    return 100 * deer["taken_in"].to_numpy()[-ticks:].sum() / deer["n"].to_numpy()[-ticks:].sum()


if __name__ == "__main__":
    within = World.from_config(
        load(GRAZING, {"species.deer.policy": {"kind": "function", "function": act}}), seed=1
    )
    random = World.from_config(GRAZING, seed=1, policies="random")
    beside = World.from_config(GRAZING, seed=1)
    door = beside.external("deer")
    for _ in range(200):
        seen = door.observe()
        door.act(act(seen.x, seen.uid))
    print(f"energy that a deer takes in: {meals(within):.2f} by hand, {meals(random):.2f} by chance")
    print(
        "within and beside the world: the same deer",
        (within.tables["deer"].by_uid().size, beside.tables["deer"].by_uid().size),
    )
