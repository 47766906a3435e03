"""Search for values with which a world persists: candidates, evaluation, optimizer, importance.

Settings of a search are in the world file (`ecs_eco.config.models.search`); statistics of single runs belong
to `ecs_eco.analysis`.
"""

from ecs_eco.lab.searching.run import search

__all__ = ["search"]
