"""Plot how many rabbits in meadow.toml are alive over time, with and without learning, for several seeds.

python examples/rabbits_learn.py [SEEDS] [FILE]
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from ecs_eco import World
from ecs_eco.config import load

WORLD = Path(__file__).with_name("meadow.toml")


def rabbits(seed: int, learn: bool) -> list[int]:
    """Return the number of rabbits at ticks 0, 10, … 1,000."""
    world = World.from_config(load(WORLD, {"species.rabbit.policy.learn": learn}), seed=seed)
    return [world.table("rabbit").n] + [world.run(10).table("rabbit").n for _ in range(100)]


if __name__ == "__main__":
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    file = sys.argv[2] if len(sys.argv) > 2 else "rabbits_learn.png"
    figure, axes = plt.subplots(figsize=(7.2, 2.9), layout="constrained")
    for learn, color, label in (
        (True, "#1b7837", "learn while they live"),
        (False, "#b35806", "do not learn"),
    ):
        runs = [rabbits(seed, learn) for seed in range(1, seeds + 1)]
        for run in runs:
            axes.plot(range(0, 1001, 10), run, color=color, linewidth=1.0, alpha=0.6)
        print(f"rabbits that {label}: {', '.join(str(run[-1]) for run in runs)} alive at tick 1,000")
        axes.text(1010, sum(run[-1] for run in runs) / seeds, label, color=color, va="center")
    axes.set(xlim=(0, 1000), ylim=(0, None), xlabel="tick [s]", ylabel="rabbits alive")
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(file, dpi=130, metadata={"Software": None})
