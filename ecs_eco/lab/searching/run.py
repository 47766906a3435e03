"""A whole search, from a world's ranges to its report."""

from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from ecs_eco.config import load
from ecs_eco.config.overrides import Overrides
from ecs_eco.engine.arguments import called_with
from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest
from ecs_eco.lab.executors import LOCAL, engine, prepare, workers_of
from ecs_eco.lab.searching.course import Progress, Search
from ecs_eco.lab.searching.optimise import OPTIMISERS
from ecs_eco.lab.searching.plan import plan_of
from ecs_eco.lab.searching.report import WorldFile, write_results
from ecs_eco.lab.searching.sampler import SAMPLERS
from ecs_eco.lab.work import Work
from ecs_eco.record.claim import Claim, ours


def search(
    world: WorldFile,
    out: str | Path | Claim,
    overrides: Overrides = None,
    *,
    budget: float | None = None,
    trials: int | None = None,
    cpu: float | None = None,
    workers: int | None = None,
    optimiser: str = "gp",
    progress: Progress | None = None,
    report: bool = True,
    trust: bool = False,
    executor: str | Executor = LOCAL,
) -> dict[str, Any]:
    """Search the ranges in a world's [search]; write a folder, return the content of its search.json.

    `overrides` are as for `load`, "search.ticks" and similar keys included. It ends after `budget` minutes,
    `trials` candidates, or `cpu` CPU seconds of candidates, earlier calls included: a folder with a search is
    continued. `trust` allows the code that the world lists to run in this process and its workers. `executor`
    is "local" (two `workers` by default), "ray", or your own executor. Raises ConfigError; FolderInUse if
    another process searches there; ForeignFile if it contains another search.
    """
    called_with("progress", progress, "the search")
    config = load(world, overrides, trust=trust)
    plan = plan_of(config)
    if optimiser not in (known := (*OPTIMISERS, *SAMPLERS)):
        near = nearest(optimiser, known)
        raise ConfigError([Problem((), "no such optimiser", optimiser, listed(known), near, "--optimiser")])
    if optimiser in SAMPLERS:
        if plan.fit is None:
            allowed = 'a world with [data], and [search] objective = "data"'
            fault = "samples numbers that fit measurements, but the world names none"
            raise ConfigError([Problem((), fault, optimiser, allowed, source="--optimiser")])
        plan = plan.sampling()
    with ours(out) as claim:
        folder = claim.path if executor == LOCAL else claim.path.absolute()
        running = None
        try:
            with engine(executor, workers) as pool, Work[Any](pool) as work:
                most = workers or workers_of(pool)
                running = Search(plan, folder, work, most, optimiser, budget, trials, cpu, progress)
                prepare(pool, folder, config)
                running.run()
        finally:
            if running is not None:
                running.sweep()
        return write_results(running, world, overrides, report)
