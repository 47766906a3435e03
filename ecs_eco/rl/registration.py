"""The environments for `gymnasium.make`: each is one species of a shipped world."""

from __future__ import annotations

from importlib.util import find_spec

NAMESPACE = "ecs_eco"
STEPS = 1000  # of an episode
ENVIRONMENTS = {
    "Deer-v0": ("predator_prey", "deer"),
    "Wolf-v0": ("predator_prey", "wolf"),
    "Copepod-v0": ("diel_migration", "copepod"),
    "Krill-v0": ("learning_krill", "krill"),
    "Lamb-v0": ("lamb", "lamb"),
    "Vole-v0": ("happiness", "vole"),
    "IslandDeer-v0": ("island", "deer"),
    "IslandWolf-v0": ("island", "wolf"),
    "Raven-v0": ("island", "raven"),
}
"""The world and species of each environment, by name."""


def register() -> None:
    """Register the environments with Gymnasium if it is installed and they are not yet registered."""
    if find_spec("gymnasium") is None:
        return
    from gymnasium.envs.registration import register as enter, registry

    for name, (world, species) in ENVIRONMENTS.items():
        if (full := f"{NAMESPACE}/{name}") not in registry:
            enter(
                id=full,
                entry_point="ecs_eco.rl.single:body",
                vector_entry_point="ecs_eco.rl.vector:slots",
                max_episode_steps=STEPS,
                kwargs={"world": world, "species": species},
            )


def needed(module: str) -> ModuleNotFoundError:
    """Return the error for a missing optional package."""
    message = f'{module} is not installed: pip install -e ".[rl]" in the source folder'
    return ModuleNotFoundError(message, name=module)
