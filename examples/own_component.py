"""A component of your own on a shipped species: deer get wool,
which grows and makes living in the cold cheaper."""

import numpy as np

from ecs_eco import System, World, component, f32
from ecs_eco.components import Metabolism


@component
class Wool:
    """The coat of one animal."""

    length: f32 = 0.01  # [m]
    growth: f32 = 1e-4  # [m/s]


class GrowWool(System):
    """Wool grows up to 5 cm; each centimetre saves a tenth of what the cold costs."""

    needs = (Wool, Metabolism)
    phase = "metabolise"

    def start(self, world: World) -> None:
        """Give every deer, living or to come, its wool."""
        world.table("deer").add_component(Wool, growth=2e-4)

    def update(self, table, world) -> None:
        wool, m, who = table[Wool], table[Metabolism], table.rows()
        wool.length[who] = np.minimum(wool.length[who] + wool.growth[who] * world.dt, 0.05)
        before = m.energy[who]
        m.energy[who] -= np.float32(0.002 * world.dt) * np.maximum(1 - 10 * wool.length[who], 0)
        m.burnt[who] += before - m.energy[who]  # so that the energy ledger closes


if __name__ == "__main__":
    world = World.from_config("predator-prey", policies="random", systems=[GrowWool()]).run(20)
    deer = world.table("deer")
    print(world)
    print(f"wool: {deer[Wool].length[deer.rows()].mean() * 100:.2f} cm on average")
    uid = int(deer.uid[deer.rows()[0]])
    print(f"the deer {uid} has {world.get(uid, Wool)}")
