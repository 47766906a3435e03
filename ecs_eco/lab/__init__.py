"""Many runs as one lab book: a job is a world, its values, a seed, a treatment and policies; a plan is a list of
jobs. Comparisons, sweeps, searches and archipelagos, on processes here, a Ray cluster or SLURM.

Single runs belong to `ecs_eco.runs`, statistics to `ecs_eco.analysis`, output on the terminal to
`ecs_eco.cli`: nothing here prints.
"""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy, listing

if TYPE_CHECKING:
    from ecs_eco.lab.archipelago import Archipelago
    from ecs_eco.lab.comparison import compare
    from ecs_eco.lab.jobs import run_job
    from ecs_eco.lab.pretraining import pretrain
    from ecs_eco.lab.searching.run import search
    from ecs_eco.lab.sweep import run_sweep

__all__ = ["Archipelago", "compare", "pretrain", "run_job", "run_sweep", "search"]
_HOME = {
    "Archipelago": "archipelago",
    "compare": "comparison",
    "pretrain": "pretraining",
    "run_job": "jobs",
    "run_sweep": "sweep",
    "search": "searching.run",
}
__getattr__ = lazy(__name__, {name: f"ecs_eco.lab.{module}" for name, module in _HOME.items()})
__dir__ = listing(globals(), __all__)
