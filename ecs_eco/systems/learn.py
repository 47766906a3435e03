"""Policies learn from what happened."""

from typing import Any

from ecs_eco.components import Nervous
from ecs_eco.system import System


class Learn(System):
    """When a rollout is full, PPO updates the policy of the species; the living bootstrap with the value of what they sense."""

    needs = (Nervous,)
    phase = "learn"

    def update(self, table: Any, world: Any) -> None:
        """Update the brain of one species when it is time."""
        nerves = table.traits["nerves"]
        if nerves.learning and nerves.learner.full:
            _, values = nerves.brain.forward(nerves.x, workers=world.threads)
            nerves.reports.append({"tick": world.tick, **nerves.learner.update(nerves.rows, values)})
