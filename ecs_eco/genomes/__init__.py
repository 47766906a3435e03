"""Heredity: genomes as strings over a finite alphabet, and what makes new ones of them.

What a genome says of a body or a brain belongs to its layout; how an organism with it lives belongs to `systems`.
"""

from ecs_eco.genomes.alphabet import DNA, Alphabet

__all__ = ["DNA", "Alphabet"]
