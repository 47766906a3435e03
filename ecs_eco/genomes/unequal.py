"""Unequal crossover of strings of variable length, cut at genes, with the signature of DEAP's crossovers."""

import random

from ecs_eco.genomes.promoters import copies_in
from ecs_eco.genomes.variable_layout import VariableLayout

SLIP = 0.1  # by default


class UnequalCrossover:
    """A crossover of strings of a layout: `mate(a, b, slip)` exchanges the parts of two lists of letters'
    numbers from the promoter of a gene on.

    A gene of `a` and its counterpart in `b` are cut: the copy of the same gene that has the same rank among
    the copies in its string or, with probability `slip`, any copy of the gene, as when chromosomes pair out
    of register. All pairs of counterparts are equally likely. If the strings share no gene nothing happens.
    Both lists are changed, and returned. `Operators` computes all births of a tick at once by a kernel of the
    same distribution instead.
    """

    __name__ = "cxUnequal"

    def __init__(self, layout: VariableLayout) -> None:
        self.layout = layout

    def __call__(self, a: list[int], b: list[int], slip: float = SLIP) -> tuple[list[int], list[int]]:
        """Return both lists, crossed."""
        pairs = self.pairs(a, b, random.random() < slip)
        if pairs:
            i, j = random.choice(pairs)
            a[i:], b[j:] = b[j:], a[i:]
        return a, b

    def pairs(self, a: list[int], b: list[int], slipped: bool) -> list[tuple[int, int]]:
        """Return the places in `a` and `b` where the promoters of counterparts begin."""
        first, second = (self._ranked(string) for string in (a, b))
        return [
            (at, other)
            for gene, rank, at in first
            for same, level, other in second
            if gene == same and (slipped or rank == level)
        ]

    def _ranked(self, string: list[int]) -> list[tuple[str, int, int]]:
        """Return each copy's gene, its rank among the copies of the gene, and its place."""
        layout, seen = self.layout, dict.fromkeys(self.layout.promoters, 0)
        spans = {code.name: int(span) for code, span in zip(layout.genes, layout.spans, strict=True)}
        text, out = "".join(layout.alphabet.letters[i] for i in string), []
        for gene, at in copies_in(text, layout.promoters, spans):
            out.append((gene, seen[gene], at))
            seen[gene] += 1
        return out
