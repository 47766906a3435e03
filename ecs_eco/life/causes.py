"""Causes of death that follow from a species' diet and limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.engine.world import World


def register_eaters(world: World, table: Table) -> None:
    """Register the causes of death for a species' prey and for animals killed by deadly food."""
    for food in table.species.foods:
        world.cause(f"eaten by {table.name}")
        if food.deadly:
            world.cause(f"poisoned by {food.eats}")


def register_limits(world: World, table: Table) -> None:
    """Register a cause of death for each end of each range in which a species can live."""
    for limit in table.species.lethal:
        for cause, bound in ((limit.cause_below, limit.min), (limit.cause_above, limit.max)):
            if bound is not None:
                world.cause(cause)
