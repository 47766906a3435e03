"""Learning while alive: an actor-critic network and PPO, for a population whose members are born and die in mid-rollout.

Here belong optimisers of policies and what they need; how an organism senses, decides and is rewarded belongs to
`nervous` and `systems`. Nothing here knows biology, and the parts also train plain Gymnasium vector environments.
Names load when first used: `from ecs_eco.learning import PPO` loads neither torch nor numba.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .brain import Brain, choose, choose_best
    from .ppo import Learner
    from .rollout import Rollout
    from .settings import PPO
    from .vector_env import Training, train

__all__ = ["PPO", "Brain", "Learner", "Rollout", "Training", "choose", "choose_best", "train"]

_HOME = {
    "PPO": "settings",
    "Brain": "brain",
    "choose": "brain",
    "choose_best": "brain",
    "Rollout": "rollout",
    "Learner": "ppo",
    "Training": "vector_env",
    "train": "vector_env",
}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"ecs_eco.learning has no {name!r}; it has {', '.join(__all__)}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
