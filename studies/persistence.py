"""Do grass, deer and wolves persist and cycle for the recipe, whatever the training seed, with frozen policies and with learning in life?

No policy is selected: each is trained from its own seed by the shipped recipe and lives in every world of the grid. Learning in
life comes in two ways: as the world file says, with the hyperparameters of pre-training, and slowly, with wolves that keep ahead.
"""

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from _crossed import crossed_study

TRAINING, WORLDS = range(71, 77), range(7201, 7206)  # seen by nothing before


def in_life(deer: float, wolf: float) -> dict[str, Any]:
    """An arm in which both go on learning at these rates."""
    return {"learn": True, "life": {"species.deer.ppo.learning_rate": deer, "species.wolf.ppo.learning_rate": wolf}}


ARMS: dict[str, dict[str, Any]] = {
    "frozen": {"learn": False},
}
STUDY = crossed_study("persistence", "Grass, deer and wolves persist and cycle for the recipe, whatever the training seed.", ARMS, TRAINING, WORLDS,
                      ticks=20_000, judged=["frozen"],
                      also=[{"arm": "frozen", "training": TRAINING[0], "seed": 7101, "ticks": 80_000}])  # fmt: skip

if __name__ == "__main__":
    STUDY.main()
