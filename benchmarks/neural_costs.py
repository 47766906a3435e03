"""Measure the system that charges animals for hidden units, receptors and learning, as a share of a tick.

    python benchmarks/neural_costs.py

The costs are so small that animals hardly notice them. A pair of worlds with and without costs would soon
differ in its animals, so the system is timed alone, on the animals of the running world.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

from ecs_eco import World
from ecs_eco.config import load

COSTS = {"hidden_unit": 1e-7, "receptor": 5e-7, "transition": 1e-7}
WORLDS = {"predator-prey": ("deer", "wolf"), "innate": ("goat",)}
GOAL, TICKS = 1.02, 40


def measured(name: str) -> dict[str, object]:
    """Run one world with costs for 200 ticks; time whole ticks and the system alone."""
    costs = {f"species.{species}.neural_costs": COSTS for species in WORLDS[name]}
    world = World.from_config(load(name, costs), seed=1, record=False)
    world.run(200)
    tick = _bench.best_of(lambda: world.run(TICKS)) / TICKS
    system = next(one for one in world.systems if type(one).__name__ == "MaintainNerves")
    tables = [world.table(species) for species in WORLDS[name]]
    alone = _bench.best_of(lambda: [system.update(table, world) for table in tables] and None, 40)
    ratio = tick / (tick - alone)
    return {"world": name, "tick [us]": tick * 1e6, "system [us]": alone * 1e6, "ratio": ratio, "goal": GOAL}


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__.partition("\n\n")[0]).parse_args()
    rows = [measured(name) for name in WORLDS]
    _bench.save("neural_costs", "Ticks with costs of nervous systems, relative to ticks without", rows)
