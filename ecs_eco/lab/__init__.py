"""Many runs, planned and executed as jobs: each job is a world with its values, seed, treatment and policies.

Comparisons, sweeps, searches, archipelagos and training run in local processes, a Ray cluster or SLURM.
`treatments` and `arm` define how runs differ; `plan` and `design` list the runs; `runs` and `trained` execute
one job, and `work` executes all jobs, on an executor (`pool`, `ray_executor`); `slurm` submits whole sweeps.
This package prints nothing; for single runs see `ecs_eco.runs`, for statistics `ecs_eco.analysis`, for
terminal output `ecs_eco.cli`.
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
