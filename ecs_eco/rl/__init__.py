"""External reinforcement learning: species as PettingZoo and Gymnasium environments.

All use the external control in `ecs_eco.nervous`; for learning within a world, see `ecs_eco.learning`.
Requires the `rl` extra: `pip install -e ".[rl]"`. Importing this package registers the environments, as in
`gymnasium.make("ecs_eco/Deer-v0")`.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy, listing
from ecs_eco.rl.registration import ENVIRONMENTS, register

if TYPE_CHECKING:
    from ecs_eco.rl.parallel import parallel_env
    from ecs_eco.rl.sb3 import vec_env
    from ecs_eco.rl.single import body
    from ecs_eco.rl.vector import slots

__all__ = ["ENVIRONMENTS", "body", "parallel_env", "slots", "vec_env"]

_HOME = {"body": "single", "parallel_env": "parallel", "slots": "vector", "vec_env": "sb3"}
__getattr__ = lazy(__name__, {name: f"ecs_eco.rl.{module}" for name, module in _HOME.items()})
__dir__ = listing(globals(), __all__)
register()
