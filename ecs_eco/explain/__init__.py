"""Explanations of evolution in recorded runs: which alleles rose, when, and by how much more than chance.

`drift` measures how unequal organisms' contributions to the next generation are, `alleles` follows the
frequencies of all alleles, and `events` tests them and groups linked alleles into sweeps. Statistics of a
single gene that you choose belong in `ecs_eco.analysis`.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy

if TYPE_CHECKING:
    from ecs_eco.explain.alleles import Allele as Allele, Paths as Paths, follow as follow, shares as shares
    from ecs_eco.explain.drift import Steps as Steps, steps_of as steps_of
    from ecs_eco.explain.events import (
        Assessment as Assessment,
        Sweep as Sweep,
        assess as assess,
        rises as rises,
    )

__getattr__ = lazy(
    __name__,
    {
        ".alleles": "Allele Paths follow shares",
        ".drift": "Steps steps_of",
        ".events": "Sweep Assessment rises assess",
    },
)
