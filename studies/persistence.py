"""Do grass, deer and wolves persist and cycle under the shipped recipe, for any training seed?

No policy is selected: each policy is trained from its own seed with the shipped recipe and then lives,
frozen, in every world in the grid; each run lasts more than 50 periods. For learning that continues during
life, see learning_in_life.py.
"""

from typing import Any

from studies.common.seed_grid import crossed_study

TRAINING, WORLDS = range(901, 921), range(7301, 7303)  # fresh seeds


ARMS: dict[str, dict[str, Any]] = {"frozen": {"learn": False}}
STUDY = crossed_study(
    "persistence",
    "Grass, deer and wolves persist and cycle with the shipped training recipe, for most training seeds.",
    ARMS,
    TRAINING,
    WORLDS,
    ticks=20_000,
    judged=["frozen"],
    also=[{"arm": "frozen", "training": TRAINING[0], "seed": 7303, "ticks": 80_000}],
)

if __name__ == "__main__":
    STUDY.main()
