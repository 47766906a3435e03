"""What features that change the substances of bodies check alike."""

from __future__ import annotations

from ecs_eco.config.features.feature import WorldSections


def substances_of(config: WorldSections, name: str | int) -> set[str]:
    """Return the substances that bodies of a kind are declared to hold, of remains those of the dead too."""
    kind = config.species.get(str(name)) or config.objects[str(name)]
    dead = [s.substances for s in config.species.values() if s.remains == name]
    return {substance for held in (kind.substances, *dead) for substance in held}
