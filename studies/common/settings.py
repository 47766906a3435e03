"""PPO settings under the names that they had when results were first hashed."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from ecs_eco.learning import PPO
from ecs_eco.learning.aliases import FORMER


def as_hashed(ppo: PPO) -> dict[str, Any]:
    """Return settings by their former names, for the config of a study."""
    before = {name: former for former, name in FORMER.items()}
    return {before.get(name, name): value for name, value in asdict(ppo).items()}


def from_hashed(settings: Mapping[str, Any]) -> PPO:
    """Return the settings that the config of a study contains."""
    return PPO(**{FORMER.get(name, name): value for name, value in settings.items()})
