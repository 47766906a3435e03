"""Learning during life: actor-critic networks and PPO, for populations whose members are born and die
mid-rollout.

This package contains no biology and also trains plain Gymnasium vector environments. Sensing, decisions and
rewards belong in `ecs_eco.nervous` and `ecs_eco.systems`. Names are loaded lazily: `from ecs_eco.learning
import PPO` imports neither torch nor numba.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy, listing

if TYPE_CHECKING:
    from ecs_eco.learning.brain import Brain
    from ecs_eco.learning.choice import choose, choose_best
    from ecs_eco.learning.continuous import CONTINUOUS
    from ecs_eco.learning.individual import Individuals
    from ecs_eco.learning.mlp import MLP, from_torch
    from ecs_eco.learning.module_brain import ModuleBrain
    from ecs_eco.learning.ppo import Learner
    from ecs_eco.learning.rollout import Rollout
    from ecs_eco.learning.settings import PPO
    from ecs_eco.learning.torch_ppo import TorchLearner
    from ecs_eco.learning.vector_env import Training, train

__all__ = [
    "CONTINUOUS",
    "MLP",
    "PPO",
    "Brain",
    "Individuals",
    "Learner",
    "ModuleBrain",
    "Rollout",
    "TorchLearner",
    "Training",
    "choose",
    "choose_best",
    "from_torch",
    "train",
]

_HOME = {
    "PPO": "settings",
    "Brain": "brain",
    "choose": "choice",
    "choose_best": "choice",
    "CONTINUOUS": "continuous",
    "Individuals": "individual",
    "Rollout": "rollout",
    "Learner": "ppo",
    "TorchLearner": "torch_ppo",
    "ModuleBrain": "module_brain",
    "MLP": "mlp",
    "from_torch": "mlp",
    "Training": "vector_env",
    "train": "vector_env",
}
__getattr__ = lazy(__name__, {name: f"{__name__}.{module}" for name, module in _HOME.items()})
__dir__ = listing(globals(), __all__)
