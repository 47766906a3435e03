"""Many runs, planned and executed as jobs: each job is a world with its values, seed, treatment and policies.

Comparisons, sweeps, searches, archipelagos and training run in local processes, a Ray cluster or SLURM.
`treatments` defines how runs differ; `plan` and `design` list the runs; `jobs` executes one job, and `work`
executes all jobs, on an executor (`pool`, `ray_executor`); `slurm` submits whole sweeps.
This package prints nothing; for single runs see `ecs_eco.runs`, for statistics `ecs_eco.analysis`, for
terminal output `ecs_eco.cli`."""

from typing import TYPE_CHECKING

from ecs_eco._lazy import lazy

if TYPE_CHECKING:
    from ecs_eco.lab.archipelago import Archipelago as Archipelago
    from ecs_eco.lab.comparison import compare as compare
    from ecs_eco.lab.jobs import run_job as run_job
    from ecs_eco.lab.pretraining import pretrain as pretrain
    from ecs_eco.lab.searching.report import search as search
    from ecs_eco.lab.sweep import run_sweep as run_sweep

__getattr__ = lazy(
    __name__,
    {
        ".archipelago": "Archipelago",
        ".comparison": "compare",
        ".jobs": "run_job",
        ".pretraining": "pretrain",
        ".searching.report": "search",
        ".sweep": "run_sweep",
    },
)
