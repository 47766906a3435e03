"""Measure memory per animal: columns and index; Python objects after a request for all of esper's ids, and
after esper's loop has visited a component of each animal; and a rollout transition.

    python benchmarks/memory.py [--animals 100000]
"""

import argparse
import gc
import resource
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import esper

from ecs_eco import World
from ecs_eco.components import Metabolism


def resident() -> int:
    """Return this process's memory [bytes]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize()


def main() -> None:
    """Build a small world to load all modules, then a large one; visit it through esper, and compare memory
    use."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--animals", type=int, default=100_000)
    n = parser.parse_args().animals
    small = World.from_config(
        _bench.savanna(1000, plants_per_animal=0.01), seed=1, policies="untrained", training=True, learn=True
    )
    small.run(3)
    gc.collect()
    before = resident()
    world = World.from_config(
        _bench.savanna(n, plants_per_animal=0.01), seed=1, policies="untrained", training=True
    )
    world.run(3)
    without = resident() - before
    with world:
        world.sync()  # one number per animal
        gc.collect()
        known = resident() - before
        esper.get_component(Metabolism)  # one entity and one handle per animal
        esper.clear_cache()
        gc.collect()
        looked_at = resident() - before
    columns = sum(t.nbytes for name, t in world.tables.items() if name != "plant")
    rollout = small.tables["grazer"].species.nerves.learner.rollout.nbytes_per_transition
    rows = [
        {
            "animals": n,
            "columns [B/animal]": columns / n,
            "process [B/animal]": without / n,
            "with esper ids [B/animal]": known / n,
            "goal [B/animal]": 700,
            "with one component of each animal read through esper [B/animal]": looked_at / n,
            "rollout [B/transition]": rollout,
        }
    ]
    _bench.save("memory", "Memory per animal with 24 observations, excluding the rollout", rows)


if __name__ == "__main__":
    main()
