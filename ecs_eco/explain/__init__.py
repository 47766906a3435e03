"""Explanations of evolution in recorded runs: which alleles rose, when, and what taking them out changes.

`drift` measures how unequal organisms' contributions to the next generation are, `alleles` follows the
frequencies of all alleles, and `events` tests them and groups linked alleles into sweeps. `edits` changes living
organisms, and `taken_out` compares changed and unchanged organisms in forks of the run. `account`, `figures` and
`page` present the results, and `viewed` passes sweeps to the viewer. Statistics of a single gene that you choose
belong in `ecs_eco.analysis`.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy

if TYPE_CHECKING:
    from ecs_eco.explain.account import Account as Account
    from ecs_eco.explain.alleles import Allele as Allele, Paths as Paths, follow as follow, shares as shares
    from ecs_eco.explain.drift import Steps as Steps, steps_of as steps_of
    from ecs_eco.explain.edits import Edit as Edit
    from ecs_eco.explain.events import (
        Assessment as Assessment,
        Sweep as Sweep,
        assess as assess,
        rises as rises,
    )
    from ecs_eco.explain.page import write_explanation as write_explanation
    from ecs_eco.explain.taken_out import TakenOut as TakenOut, driver as driver, take_out as take_out

__getattr__ = lazy(
    __name__,
    {
        ".account": "Account",
        ".alleles": "Allele Paths follow shares",
        ".drift": "Steps steps_of",
        ".edits": "Edit",
        ".events": "Assessment Sweep assess rises",
        ".page": "write_explanation",
        ".taken_out": "TakenOut driver take_out",
    },
)
