"""The substances in a body."""

from ecs_eco.engine.schema import component, f32, f64


@component
class Chemistry:
    """Concentrations of the world's substances, in declaration order."""

    molarity: f32["substances"] = 0.0  # [mol/L]


@component
class Matter:
    """The volume to which a body's concentrations refer, and the part of them that float32 cannot represent.

    The amount of a substance in the body is (Chemistry.molarity + residue) × volume [mol]. `Dilute` preserves
    it when a body grows or shrinks.
    """

    volume: f64.within(0, 1e300) = 0.0  # [L]; 0 until birth
    residue: f32["substances"] = 0.0  # [mol/L] to be added to Chemistry.molarity
