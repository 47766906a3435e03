"""A whole search, from the ranges in a world to the report."""

from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from ecs_eco.config.loading import WorldSource, load
from ecs_eco.config.overrides import Overrides
from ecs_eco.engine.arguments import called_with
from ecs_eco.engine.errors import listed, nearest, refusal
from ecs_eco.lab.executors import LOCAL, engine, prepare, workers_of
from ecs_eco.lab.searching.course import Progress, Search
from ecs_eco.lab.searching.optimise import OPTIMISERS
from ecs_eco.lab.searching.plan import plan_of
from ecs_eco.lab.searching.report import write_results
from ecs_eco.lab.searching.sampler import SAMPLERS
from ecs_eco.lab.work import Work
from ecs_eco.record.claim import Claim, ours


def search(
    world: WorldSource,
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
    """Search the ranges in a world's `search` section and write the results to a folder.

    Parameters
    ----------
    world : str, Path or Mapping
        A world with ranges to search.
    out : str or Path
        Results folder: new, empty, or from a search to resume.
    overrides : Mapping or sequence of str, optional
        Changes to values, as in `ecs_eco.config.load`, including keys of `search`.
    budget : float, optional
        Minutes after which the search ends, including earlier calls.
    trials : int, optional
        Number of candidates after which the search ends.
    cpu : float, optional
        CPU time of candidates [s] after which the search ends.
    workers : int, optional
        Number of processes; default: 2.
    optimiser : str, default "gp"
        "gp" (Gaussian process), "tpe" or "random"; to fit measurements, "abc" or "abc-smc".
    progress : callable, optional
        Function called with the search after each candidate.
    report : bool, default True
        Whether to write search.html.
    trust : bool, default False
        Whether code listed in the world file can run in this process and its workers.
    executor : str or Executor, default "local"
        "local", "ray", or your own executor.

    Returns
    -------
    dict
        Contents of search.json: the best values, their importance, and the confirmation on fresh seeds.

    Raises
    ------
    ConfigError
        If the world or the optimizer is invalid.
    FolderInUse
        If another process is searching there.
    ForeignFile
        If the folder contains another search.

    Examples
    --------
    >>> from ecs_eco.lab import search
    >>> energy = {"value": 0.5, "search": [0.1, 1.0]}
    >>> mite = {
    ...     "count": 4,
    ...     "body": {"radius": 0.1},
    ...     "metabolism": {"energy": energy, "energy_max": 1.0, "basal": 0.02},
    ...     "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
    ... }
    >>> world = {"format": 1, "name": "fell", "ticks": 60, "space": {"size": [20.0, 20.0]}}
    >>> plan = {"world_seeds": 1, "finalists": 1, "confirm": {"world_seeds": 1}}
    >>> world |= {"species": {"mite": mite}, "search": plan}
    >>> found = search(world, "found", trials=2, workers=1, report=False)
    >>> "best" in found
    True
    """
    called_with("progress", progress, "the search")
    config = load(world, overrides, trust=trust)
    plan = plan_of(config)
    if optimiser not in (known := (*OPTIMISERS, *SAMPLERS)):
        near = nearest(optimiser, known)
        raise refusal((), "no such optimizer", optimiser, listed(known), near, "--optimiser")
    if optimiser in SAMPLERS:
        if plan.fit is None:
            allowed = 'a world with [data], and [search] objective = "data"'
            fault = "samples values that fit measurements, but the world has none"
            raise refusal((), fault, optimiser, allowed, source="--optimiser")
        plan = plan.sampling()
    if budget is None and trials is None and cpu is None:
        allowed = "a budget in minutes or a number of trials"
        raise refusal((), "no end", allowed=allowed, source="--budget, --trials")
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
