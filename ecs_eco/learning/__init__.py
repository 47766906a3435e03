"""Learning during life: actor-critic networks and PPO, for populations whose members are born and die
mid-rollout.

This package contains no biology and also trains plain Gymnasium vector environments. Sensing, decisions and
rewards belong in `ecs_eco.nervous` and `ecs_eco.systems`. Names are loaded lazily: `from ecs_eco.learning
import PPO` imports neither torch nor numba.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy

if TYPE_CHECKING:
    from ecs_eco.learning.brain import Brain as Brain
    from ecs_eco.learning.choice import choose as choose, choose_best as choose_best
    from ecs_eco.learning.continuous import CONTINUOUS as CONTINUOUS
    from ecs_eco.learning.individual import Individuals as Individuals
    from ecs_eco.learning.mlp import MLP as MLP, from_torch as from_torch
    from ecs_eco.learning.module_brain import ModuleBrain as ModuleBrain
    from ecs_eco.learning.ppo import Learner as Learner
    from ecs_eco.learning.rollout import Rollout as Rollout
    from ecs_eco.learning.settings import PPO as PPO
    from ecs_eco.learning.torch_ppo import TorchLearner as TorchLearner
    from ecs_eco.learning.vector_env import Training as Training, train as train

__getattr__ = lazy(
    __name__,
    {
        ".brain": "Brain",
        ".choice": "choose choose_best",
        ".continuous": "CONTINUOUS",
        ".individual": "Individuals",
        ".mlp": "MLP from_torch",
        ".module_brain": "ModuleBrain",
        ".ppo": "Learner",
        ".rollout": "Rollout",
        ".settings": "PPO",
        ".torch_ppo": "TorchLearner",
        ".vector_env": "Training train",
    },
)
