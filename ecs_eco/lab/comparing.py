"""A whole comparison from Python, on any executor; `ecs-eco compare` does the same with a bar and a table."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from ecs_eco.analysis.compare import compare as differences
from ecs_eco.engine.arguments import called_with
from ecs_eco.lab.arm import arms_of, check_training
from ecs_eco.lab.comparison import Comparison, Key, run_jobs
from ecs_eco.lab.comparison_plan import Planned, write_plan
from ecs_eco.lab.executors import LOCAL, engine, prepare
from ecs_eco.lab.runs import run_arm
from ecs_eco.lab.trained import train_or_find
from ecs_eco.record import container
from ecs_eco.record.claim import ours


def compare(
    world: str,
    treatments: Sequence[str] = ("random-policy",),
    *,
    out: str | Path,
    changes: Sequence[str] = (),
    seeds: int = 8,
    ticks: int | None = None,
    training_seeds: int | None = None,
    retrain: bool = False,
    executor: str | Executor = LOCAL,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Run a world as it is and under treatments with the same seeds into a folder, or go on there; return the
    content of its compare.json.

    `executor` is "local", "ray", or one of your own, whose workers see the folder under its absolute path.
    Raises ConfigError, ForeignFile where the folder holds another comparison, and what the first run that
    failed raised, once the others are done.
    """
    called_with("progress", progress, "done", "total")
    arms = arms_of(world, list(changes), treatments)
    check_training(arms, training_seeds, retrain)
    training = None if training_seeds is None else range(1, training_seeds + 1)
    folder = Path(out).absolute()
    ticks = ticks or arms[0].config.ticks
    comparison = Comparison(folder, arms, ticks, range(1, seeds + 1), training, retrain)
    if container.has(folder, Planned):
        container.check(folder, Planned, comparison.plan)
    errors: list[BaseException] = []

    def failed(_: Key, error: BaseException) -> None:
        errors.append(error)

    with ours(folder), engine(executor, workers) as pool:
        write_plan(folder, comparison.plan)
        prepare(pool, folder, arms[0].config)
        for work, jobs in ((train_or_find, comparison.trainings), (run_arm, comparison.runs)):
            run_jobs(
                work,
                {key: job for key, job in jobs.items() if not job.done},
                pool,
                progress or (lambda done, total: None),
                failed,
            )
            if errors:
                raise errors[0]
        return differences(
            comparison.folders(),
            folder,
            training=comparison.training_seeds_of_runs(),
            policies=comparison.policies_in_words(),
        )
