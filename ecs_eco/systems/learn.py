"""Policies learn from rewards."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ecs_eco.components import Nervous
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Learn(System):
    """The reward goes to the last decision; when a rollout is full, PPO updates the policy of the species or
    of the individual learner.

    Bootstrap values of living organisms are computed from their current observations.
    """

    needs = (Nervous,)
    phase = "learn"
    divisible = True
    submodel = Submodel("Learning", where=("policy.learn",), changes=("Policy", "Experience"))

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Credit one species' rewards, and update its brains when their rollouts are full."""
        nerves = table.species.nerves
        if nerves.learning:
            nerves.credit(table, table[Nervous].reward[nerves.rows])
            nerves.learn(table, world)
