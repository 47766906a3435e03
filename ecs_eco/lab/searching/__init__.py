"""Search for values that let a world persist: candidates, evaluation, optimizer, importance.

The settings of a search are in the world file (`ecs_eco.config.models.search`); statistics of single runs
belong in `ecs_eco.analysis`.
"""

from ecs_eco.lab.searching.report import search

__all__ = ["search"]
