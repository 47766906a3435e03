"""Unequal crossover, which cuts strings of variable length at genes and has the signature of DEAP's
crossovers."""

import random

from ecs_eco.genomes.promoters import copies_in
from ecs_eco.genomes.variable_layout import VariableLayout

SLIP = 0.1  # default


class UnequalCrossover:
    """A crossover for strings of a layout: `mate(a, b, slip)` exchanges the parts of two lists of letter
    numbers, starting at the promoter of a gene.

    The strings are cut at a gene of `a` and its counterpart in `b`. The counterpart is the copy of the gene
    with the same rank or, with probability `slip`, any copy, as when chromosomes are misaligned. All pairs of
    counterparts are equally likely. If the strings share no gene, nothing happens. Both lists are changed in
    place and returned. For all births in a tick at once, `Operators` instead uses a kernel with the same
    distribution.
    """

    __name__ = "cxUnequal"

    def __init__(self, layout: VariableLayout) -> None:
        self.layout = layout

    def __call__(self, a: list[int], b: list[int], slip: float = SLIP) -> tuple[list[int], list[int]]:
        """Cross both lists and return them."""
        pairs = self.pairs(a, b, random.random() < slip)
        if pairs:
            i, j = random.choice(pairs)
            a[i:], b[j:] = b[j:], a[i:]
        return a, b

    def pairs(self, a: list[int], b: list[int], slipped: bool) -> list[tuple[int, int]]:
        """Return the positions in `a` and `b` at which the promoters of counterparts begin."""
        first, second = (self._ranked(string) for string in (a, b))
        return [
            (at, other)
            for gene, rank, at in first
            for same, level, other in second
            if gene == same and (slipped or rank == level)
        ]

    def _ranked(self, string: list[int]) -> list[tuple[str, int, int]]:
        """Return each copy's gene, its rank among the copies of the gene, and its position."""
        layout, seen = self.layout, dict.fromkeys(self.layout.promoters, 0)
        spans = {code.name: int(span) for code, span in zip(layout.genes, layout.spans, strict=True)}
        text, out = "".join(layout.alphabet.letters[i] for i in string), []
        for gene, at in copies_in(text, layout.promoters, spans):
            out.append((gene, seen[gene], at))
            seen[gene] += 1
        return out
