"""Systems are behaviour: an esper.Processor that gets, table by table, the columns it named."""

from typing import Any

from ecs_eco.engine.phases import Scheduled
from ecs_eco.engine.table import Table
from ecs_eco.engine.world import World


class System(Scheduled):
    """What happens to all entities that have the components in `needs`, once a tick.

    A subclass declares `needs` (components) and `phase`, and defines `update(table, world)`, called for every
    table that has them all, in the order in which tables were added. A system that joins tables overrides
    `process`. `acts` are the groups of actions that it carries out, beyond those that every world knows:
    species may use them.
    """

    needs: tuple[type, ...] = ()
    acts: tuple[str, ...] = ()
    world: World

    def process(self, *args: Any, **kwargs: Any) -> None:
        """Update every table that has the needed components."""
        for table in self.world.tables.values():
            if table.has(self.needs):
                self.update(table, self.world)

    def update(self, table: Table, world: Any) -> None:
        """Change one table's columns by one tick."""
        raise NotImplementedError(f"{type(self).__name__} defines neither update(table, world) nor process()")
