"""Searching for the numbers with which a world lives: candidates, evaluation, optimiser, importance.

What a search varies and wants is said in the world file (`ecs_eco.config.models.search`); what single runs
mean belongs to `ecs_eco.analysis`.
"""

from ecs_eco.search.run import search

__all__ = ["search"]
