"""What an entity is made of, chemically."""

from ecs_eco.engine.schema import component, f32


@component
class Chemistry:
    """Concentrations of the substances that the world declares, in the order of their declaration."""

    molarity: f32["substances"] = 0.0  # [mol/L]
