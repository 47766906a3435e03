"""The parents of an organism, for species that recognize their kin."""

from ecs_eco.engine.schema import component, u64


@component
class Parentage:
    """The parents, dead or alive; founders and immigrants have no recorded parents."""

    mother: u64 = 0  # uid of the mother; 0: none
    father: u64 = 0  # uid of the father; 0: none, or a single parent
