"""A hand-written policy: a function of the readings and uids of all deer.

The same function decides inside the world, as `policy = { kind = "function", … }`, and outside it, through
`world.external`, which exchanges arrays once per tick. The resulting worlds are identical.
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
    """Turn to the nearest grass and walk there; with no grass in sight, walk straight or in a wide curve."""
    forward, left, near = (x[:, CHANNELS.index(f"grass_{way}")] for way in ("forward", "left", "near"))
    turn = np.where(left > 0.3, LEFT, np.where(left < -0.3, RIGHT, AHEAD))
    turn = np.where((forward < 0) & (turn == AHEAD), LEFT, turn)
    speed = np.where(forward > 0.5, RUN, STILL)  # turn first
    lost, side = near == 0, np.where(uid % 2, LEFT, RIGHT)
    wander = np.where(uid % 7 == 0, side, AHEAD)
    return np.stack([np.where(lost, WALK, speed), np.where(lost, wander, turn)], 1)


def meals(world: World, ticks: int = 200) -> float:
    """Return a deer's energy intake per hundred ticks."""
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
    print(f"energy intake of a deer: {meals(within):.2f} by hand, {meals(random):.2f} at random")
    print(
        "inside and outside the world, the same deer:",
        (within.tables["deer"].by_uid().size, beside.tables["deer"].by_uid().size),
    )
