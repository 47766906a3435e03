"""Do grass, deer and wolves persist when learning continues during life, as in the paper, for any training
seed?

The study runs a grid of training and world seeds with two protocols: the hyperparameters of pre-training, as
in the world file; and slow learning that keeps wolves ahead of deer, the best protocol found
(docs/explanation/learning.md).
"""

from typing import Any

from studies.common.seed_grid import crossed_study

TRAINING, WORLDS = range(71, 77), range(7201, 7206)


def in_life(deer: float, wolf: float) -> dict[str, Any]:
    """Return an arm in which both species continue to learn at these rates."""
    return {
        "learn": True,
        "life": {"species.deer.ppo.learning_rate": deer, "species.wolf.ppo.learning_rate": wolf},
    }


STUDY = crossed_study(
    "learning_in_life",
    "Grass, deer and wolves persist while deer and wolves learn slowly in life, for almost every training seed.",
    {"learning as in training": {"learn": True}, "learning slowly, wolves less so": in_life(3e-6, 1e-4)},
    TRAINING,
    WORLDS,
    ticks=20_000,
    judged=["learning as in training", "learning slowly, wolves less so"],
)

if __name__ == "__main__":
    STUDY.main()
