"""Worlds that are islands of an archipelago."""

from typing import Any


def is_island(world: Any) -> bool:
    """Return whether a world may exchange migrants with others: its ledgers have export and import."""
    return world.config is not None and world.config.archipelago is not None
