"""A custom component on a shipped species: deer have wool, which grows and reduces the cost of cold."""

import numpy as np

from ecs_eco import System, World, component, f32
from ecs_eco.components import Metabolism


@component
class Wool:
    """The coat of one animal."""

    length: f32 = 0.01  # [m]
    growth: f32 = 1e-4  # [m/s]


class GrowWool(System):
    """Grow wool up to 5 cm; each centimeter saves a tenth of the cost of cold."""

    needs = (Wool, Metabolism)
    phase = "metabolise"

    def start(self, world: World) -> None:
        """Add wool to all current and future deer."""
        world.table("deer").add_component(Wool, growth=2e-4)

    def update(self, table, world) -> None:
        wool, m, who = table[Wool], table[Metabolism], table.rows()
        wool.length[who] = np.minimum(wool.length[who] + wool.growth[who] * world.dt, 0.05)
        before = m.energy[who]
        m.energy[who] -= np.float32(0.002 * world.dt) * np.maximum(1 - 10 * wool.length[who], 0)
        m.burnt[who] += before - m.energy[who]  # keeps the energy ledger closed


if __name__ == "__main__":
    world = World.from_config("predator-prey", policies="random", systems=[GrowWool()]).run(20)
    deer = world.table("deer")
    print(world)
    print(f"wool: {deer[Wool].length[deer.rows()].mean() * 100:.2f} cm on average")
    uid = int(deer.uid[deer.rows()[0]])
    print(f"the deer {uid} has {world.get(uid, Wool)}")
