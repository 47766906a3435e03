"""PPO settings under the names that they had when results were first hashed."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from ecs_eco.learning import PPO
from ecs_eco.learning.aliases import FORMER


def as_hashed(ppo: PPO) -> dict[str, Any]:
    """Return settings under their former names, for a study's config."""
    before = {name: former for former, name in FORMER.items()}
    return {before.get(name, name): value for name, value in asdict(ppo).items()}


def from_hashed(settings: Mapping[str, Any]) -> PPO:
    """Return the settings in a study's config."""
    return PPO(**{FORMER.get(name, name): value for name, value in settings.items()})
