"""Genomes of variable length for tests: short promoters, so that strings can be read by eye."""

from typing import Any

import numpy as np

from ecs_eco.genomes import layout_of, operators_of
from ecs_eco.genomes.models import GenomeSection

GENES = [
    {"name": "red", "letters": 1, "values": [0, 1, 2, 3], "promoter": "TA"},
    {"name": "size", "letters": 2, "low": 0, "high": 15, "promoter": "GC"},
]
QUIET = {"operator": "mutUniformInt", "indpb": 0.0}


def section(**changes: Any) -> GenomeSection:
    """A section with a red gene of one letter after TA, and a size of two letters after GC."""
    return GenomeSection(**{"max_length": 24, "genes": GENES, "mutate": QUIET, **changes})


def layout(**changes: Any) -> Any:
    """The layout of such a section."""
    return layout_of(section(**changes))


def births(**changes: Any) -> Any:
    """The operators of such a section; nothing mutates unless it says so."""
    return operators_of(section(**changes), layout(**changes))


def texts(of: Any, loci: np.ndarray) -> list[str]:
    """The genomes of rows as text."""
    return [of.text(row) for row in loci]


def children(operators: Any, mother: str, father: str | None, n: int, first: int = 0) -> list[str]:
    """The texts of n children of two genomes, or of one."""
    of = operators.layout
    keys = np.arange(first, first + n, dtype=np.uint64)
    parents = [None if text is None else np.repeat(of.rows([text]), n, axis=0) for text in (mother, father)]
    return texts(of, operators.offspring(parents[0], parents[1], keys))
