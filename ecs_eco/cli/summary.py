"""What a world is, in a few lines."""

from __future__ import annotations

from typing import Any

from ecs_eco.config import WorldConfig


def _layout(config: WorldConfig, name: str) -> Any:
    from ecs_eco.config.check_genome import components_of
    from ecs_eco.genomes import Layout, policy_shapes, traits_of

    species = config.species[name]
    traits = traits_of(species, config.dims, components_of(species))
    assert species.genome is not None
    return Layout.from_config(species.genome, traits, policy_shapes(species, config.dims))


def summary(config: WorldConfig) -> str:
    """Name, space, species with their channels, actions and genes, and the hash of the configuration."""
    space = " × ".join(f"{s:g}" for s in config.space.size)
    lines = [
        f"{config.name}: {config.title}".rstrip(": "),
        f"  {space} m, {config.space.edges}, {config.dt:g} s a tick",
    ]
    for name, species in config.species.items():
        lines.append(f"  {name}: {species.count}")
        channels = species.channels(config.dims)
        if channels:
            lines.append(f"    senses {', '.join(channels)}")
        if species.actions:
            lines.append(f"    does {', '.join('.'.join(pair) for pair in species.action_list())}")
        if species.genome is not None:
            lines += [f"    {line}" for line in str(_layout(config, name)).splitlines()]
    lines += [f"  {name}: {kind.count or len(kind.at)}" for name, kind in config.objects.items()]
    return "\n".join([*lines, f"  configuration {config.config_hash[:16]}, no problems"])
