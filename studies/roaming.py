"""Deer with continuous speed and turn persist in a dedicated world, and go extinct without training.

    python -m studies.roaming [--short]

The world is examples/roaming.toml. These hypotheses were written before the final run (seeds 1-10; results
for seeds 100-103 were already known):
1. Deer whose policy was pre-trained with their world's seed and training recipe, and which
   continue to learn, persist for 6,000 ticks, with never fewer than ten deer, in at least 9 of 10 worlds.
2. Deer that draw speed and turn uniformly at random go extinct in at least 9 of 10 worlds.
"""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco import World
from ecs_eco.components import Motor
from ecs_eco.config import load
from ecs_eco.lab.pretraining import pretrain
from studies.common.study import Study, verdict

WORLD = Path(__file__).parents[1] / "examples" / "roaming.toml"
EVERY = 20  # ticks between counts


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one world; count its deer, and measure how they move at the end."""
    loaded, seed = load(str(WORLD)), case["seed"]
    with tempfile.TemporaryDirectory() as folder:
        if case["arm"] == "trained":
            pretrain(loaded, seed, config["training"], folder)
        policies = folder if case["arm"] == "trained" else case["arm"]
        living = load(str(WORLD), {"species.deer.ppo.anneal": 0})  # the learning rate is constant during life
        world = World.from_config(living, seed=seed, policies=policies, record=False)
    deer, counts = world.table("deer"), []
    while world.tick < config["ticks"] and (not counts or counts[-1]):
        counts.append(world.run(EVERY).table("deer").n)
    speed, turn = deer[Motor].command[deer.rows()].T if deer.n else np.zeros((2, 1))
    return {
        "fewest": min(counts),
        "mean": round(float(np.mean(counts)), 1),
        "most": max(counts),
        "died out at": world.tick if not counts[-1] else None,
        "speed": round(float(speed.mean()), 3),
        "turn": round(float(np.abs(turn).mean()), 3),
    }


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Count the worlds in which deer persisted and the worlds in which they went extinct."""
    arms = {arm: [c["result"] for c in cases if c["case"]["arm"] == arm] for arm in ("trained", "random")}
    trained, drawn = arms["trained"], arms["random"]
    persist, gone = sum(r["fewest"] >= 10 for r in trained), sum(r["died out at"] is not None for r in drawn)
    rows = [
        [
            c["case"]["arm"],
            c["case"]["seed"],
            *(c["result"][k] for k in ("fewest", "mean", "most", "died out at", "speed", "turn")),
        ]
        for c in cases
    ]
    return {
        "verdicts": [
            verdict(
                "runs with ten or more trained deer at all times",
                f"{persist} of {len(trained)}",
                ">= 9 of 10",
                persist >= 0.9 * len(trained),
            ),
            verdict(
                "runs in which deer that draw speed and turn uniformly die out",
                f"{gone} of {len(drawn)}",
                ">= 9 of 10",
                gone >= 0.9 * len(drawn),
            ),
        ],
        "table": {
            "head": [
                "policy",
                "seed",
                "fewest deer",
                "mean number of deer",
                "most deer",
                "died out at tick",
                "mean speed [m/s]",
                "mean |turn| [rad/s]",
            ],
            "rows": rows,
        },
    }


STUDY = Study(
    name="roaming",
    claim=str(__doc__).split("\n")[0],
    run=run,
    summarise=summarise,
    config={"ticks": 6000, "training": 2000},
    cases=[{"seed": seed, "arm": arm} for arm in ("trained", "random") for seed in range(1, 11)],
    short_cases=[{"seed": 1, "arm": arm} for arm in ("trained", "random")],
    short_config={"ticks": 200, "training": 100},
)

if __name__ == "__main__":
    STUDY.main()
