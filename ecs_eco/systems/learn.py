"""Policies learn from what happened."""

from typing import Any

from ecs_eco.components import Nervous
from ecs_eco.engine.system import System


class Learn(System):
    """When a rollout is full, PPO updates the policy of the species, or of the individual that has its own.

    The living bootstrap with the value of what they sense.
    """

    needs = (Nervous,)
    phase = "learn"

    def update(self, table: Any, world: Any) -> None:
        """Update the brains of one species when it is time."""
        nerves = table.species.nerves
        if nerves.learning:
            nerves.learn(table, world)
