"""Genomes, and the individual values that they encode."""

from ecs_eco.engine.schema import component, f32, u8


@component
class Genome:
    """A string over a finite alphabet, stored as one letter index per locus."""

    loci: u8["loci"].within(0, "highest letter") = 0  # from 0 to the size of the alphabet − 1


@component
class Traits:
    """Individual values of the world-file keys that genes code for, in the order of `Species.traits`."""

    value: f32["traits"] = 0.0  # [unit of the key]
