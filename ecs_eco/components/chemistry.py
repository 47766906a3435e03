"""The chemical composition of an entity."""

from ecs_eco.engine.schema import component, f32


@component
class Chemistry:
    """Concentrations of the world's substances, in declaration order."""

    molarity: f32["substances"] = 0.0  # [mol/L]
