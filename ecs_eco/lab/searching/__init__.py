"""Searching for the numbers with which a world lives: candidates, evaluation, optimiser, importance.

Settings of a search stand in the world file (`ecs_eco.config.models.search`); statistics of single runs
belong to `ecs_eco.analysis`.
"""

from ecs_eco.lab.searching.run import search

__all__ = ["search"]
