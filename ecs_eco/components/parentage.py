"""Whose child an organism is, of species that know their kin."""

from ecs_eco.engine.schema import component, u64


@component
class Parentage:
    """The parents, dead or alive; of founders and immigrants there are none."""

    mother: u64 = 0  # uid of the one who bore it; 0: none
    father: u64 = 0  # uid; 0: none, or it has one parent
