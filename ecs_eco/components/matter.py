"""What a body needs besides concentrations so that its substances add up."""

from ecs_eco.engine.schema import component, f32, f64


@component
class Matter:
    """The volume that the concentrations of a body refer to, and what of them float32 cannot hold.

    The amount of a substance in it is (Chemistry.molarity + residue) × volume [mol]. `Dilute` keeps it where
    a body grows or shrinks.
    """

    volume: f64.within(0, 1e300) = 0.0  # [L]; 0 until it is born
    residue: f32["substances"] = 0.0  # [mol/L] to be added to Chemistry.molarity
