"""What a world is, in a few lines."""

from __future__ import annotations

from ecs_eco.config import WorldConfig


def summary(config: WorldConfig) -> str:
    """Name, space, species with their channels and actions, and the hash of the configuration."""
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
    lines += [f"  {name}: {kind.count or len(kind.at)}" for name, kind in config.objects.items()]
    return "\n".join([*lines, f"  configuration {config.config_hash[:16]}, no problems"])
