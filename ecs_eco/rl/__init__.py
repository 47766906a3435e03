"""External reinforcement learning: species as PettingZoo and Gymnasium environments.

All use the external control in `ecs_eco.nervous`; for learning within a world, see `ecs_eco.learning`.
Requires the `rl` extra: `pip install -e ".[rl]"`. Importing this package registers the environments, as in
`gymnasium.make("ecs_eco/Deer-v0")`.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy
from ecs_eco.rl.registration import register

if TYPE_CHECKING:
    from ecs_eco.rl.parallel import parallel_env as parallel_env
    from ecs_eco.rl.registration import ENVIRONMENTS as ENVIRONMENTS
    from ecs_eco.rl.sb3 import vec_env as vec_env
    from ecs_eco.rl.single import body as body
    from ecs_eco.rl.vector import slots as slots

__getattr__ = lazy(
    __name__,
    {
        ".parallel": "parallel_env",
        ".registration": "ENVIRONMENTS",
        ".sb3": "vec_env",
        ".single": "body",
        ".vector": "slots",
    },
)
register()
