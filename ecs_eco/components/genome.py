"""Heredity as data."""

from ecs_eco.engine.schema import component, u8


@component
class Genome:
    """A string over a finite alphabet, stored as one letter index per locus."""

    loci: u8["loci"].within(0, "highest letter") = 0  # from 0 to the size of the alphabet − 1
