"""A nervous system at work: a newborn lamb's readings, policy and actions in each second, first at a pool,
then at an udder."""

from ecs_eco import World
from ecs_eco.components import Nervous
from ecs_eco.config import load
from ecs_eco.testing import arrange

CHANNELS = ("touch_udder", "touch_water", "glucose", "oxygen")


def watch(world: World, seconds: int) -> None:
    """Print the readings and actions of the first lamb."""
    lambs = world.table("lamb")
    nerves, row = lambs.species.nerves, lambs.by_uid()[0]
    print(f"{'second':>6}  {'  '.join(CHANNELS)}  does")
    for _ in range(seconds):
        world.run(1)
        x = nerves.x[list(nerves.rows).index(row)]
        felt = "  ".join(f"{x[nerves.channels.index(c)]:{len(c)}.2f}" for c in CHANNELS)
        does = [
            action for (_, action), on in zip(nerves.actions, lambs[Nervous].decision[row], strict=True) if on
        ]
        print(f"{world.tick:6}  {felt}  {', '.join(does)}")


if __name__ == "__main__":
    tired = {
        "species.lamb.substances.glucose": 0.003,
        "species.lamb.locomotion": {"speed": {"still": 0.0, "walk": 0.01}, "turn": 0.05},
    }
    world = World.from_config(load("lamb", tired), seed=4)
    arrange(world, "ewe", x=5, y=5)
    arrange(world, "water", x=2, y=2)
    arrange(world, "lamb", x=1.7, y=2, heading=0)
    print("It bends over a pool: whatever its policy chooses, it does not inhale.")
    watch(world, 8)
    arrange(world, "lamb", x=4.2, y=5, heading=0)
    print("It touches an udder: whatever its policy chooses, it sucks. After four seconds milk flows.")
    watch(world, 8)
