"""The course of a search: ask, evaluate, tell; then finals and confirmation. Its entire state is in its folder."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.engine.errors import ForeignFile, refusal
from ecs_eco.lab.searching.evaluate import Job, evaluate
from ecs_eco.lab.searching.journal import begin
from ecs_eco.lab.searching.optimise import Optimiser, merit
from ecs_eco.lab.searching.plan import Budget, Plan
from ecs_eco.lab.searching.sampler import SAMPLERS, Sampler
from ecs_eco.lab.trained import forget_trained
from ecs_eco.lab.work import Work
from ecs_eco.record.container import inside

BEST = 5  # number of worlds written
ENOUGH = 4  # number of candidates that a stage needs before it requires a score
Progress = Callable[["Search"], None]


class Search:
    """One search: its plan, journal, running jobs, and budget."""

    def __init__(
        self,
        plan: Plan,
        out: Path,
        work: Work[Any],
        workers: int,
        optimiser: str,
        budget: float | None,
        trials: int | None,
        cpu: float | None,
        progress: Progress | None,
    ) -> None:
        self.work, self.workers = work, workers
        self.plan, self.out, self.optimiser = plan, out, optimiser
        self.journal = begin(out, {**plan.header(), "optimiser": optimiser})
        self.sampler = Sampler(plan, optimiser, self.journal) if optimiser in SAMPLERS else None
        self.proposer = self.sampler or Optimiser(plan.parameters, optimiser, plan.config.search.seed)
        self.proposed: dict[int, dict[str, float]] = {}
        self.phase, self._progress = "searching", progress
        for entry in self.journal.of("candidate"):
            if entry["values"].keys() != plan.start.keys():
                raise ForeignFile(
                    f"{self.journal.path}: candidate {entry['candidate']}: values: their keys "
                    "differ from those of the ranges"
                )
            self.proposer.tell(entry["candidate"], entry["values"], merit(entry))
        self.budget = Budget(plan, self.journal, lambda: len(self._finalists()), budget, trials, cpu, workers)

    def run(self) -> None:
        """Search and, unless this is a sampler, compare and confirm the best candidates on fresh seeds."""
        self._candidates()
        if self.sampler is not None:
            return
        self.phase = "finals"
        self._finals()
        self.phase = "confirming"
        self._confirmation()

    def _candidates(self) -> None:
        known = {e["candidate"] for e in self.journal.of("candidate")}
        numbers = (number for number in count() if number not in known)  # candidate 0 is the world as written
        coming, waiting, sampler = next(numbers), True, self.sampler
        while waiting or len(self.work):
            while waiting and len(self.work) < self.workers and (sampler is None or sampler.ready(coming)):
                is_last = sampler is not None and sampler.finished(coming)
                waiting = self.budget.allows_another(len(self.work)) and not is_last
                if waiting:
                    values = self.proposer.ask(coming) if coming else self.plan.start
                    self.proposed[coming] = values
                    self.work.add(coming, evaluate, self._job(coming, values if coming else {}))
                    coming = next(numbers)
            for number, result in self._results():
                self._tell(number, self.proposed.pop(number), result)
            if len(self.work) and self.budget.is_over():
                self.work.stop()
                return

    def _tell(self, number: int, values: dict[str, float], result: dict[str, Any]) -> None:
        if number == 0 and ("failed" in result or "refused" in result):
            fault = f"cannot be evaluated: {result.get('failed') or result['refused']}"
            raise refusal((), fault, source="the world as written")
        entry = self.journal.add(
            "candidate", candidate=number, values=values, **result, at=self.budget.elapsed
        )
        self.proposer.tell(number, values, merit(entry))
        if number and entry not in self.ranked()[: max(BEST, self.plan.config.search.finalists)]:
            self._forget(number)

    def _finals(self) -> None:
        known = {e["candidate"] for e in self.journal.of("final")}
        wanted = [e for e in self._finalists() if e["candidate"] not in known]
        jobs = {e["candidate"]: self._whole(e, self.plan.finals, self.plan.ticks) for e in wanted}
        for number, result in self._all(jobs):
            self.journal.add("final", candidate=number, **result, at=self.budget.elapsed)

    def _finalists(self) -> list[dict[str, Any]]:
        """Return the best candidates that passed all runs; none if there is only one."""
        last = len(self.plan.stages) - 1
        best = [e for e in self.ranked() if e["stage"] == last][: self.plan.config.search.finalists]
        return best if len(best) > 1 else []

    def _confirmation(self) -> None:
        known = {(e["candidate"], *e["cell"]) for e in self.journal.of("confirmation")}
        best, start = self.best(), next(e for e in self.journal.of("candidate") if e["candidate"] == 0)
        jobs = {}
        for entry in [best, start] if best is not start else [best]:
            for cell in self.plan.confirmation:
                if (entry["candidate"], *cell) not in known:
                    jobs[entry["candidate"], cell] = self._whole(entry, [cell], self.plan.confirmation_ticks)
        for (number, cell), result in self._all(jobs):
            self.journal.add("confirmation", candidate=number, cell=cell, **result, at=self.budget.elapsed)

    def _all(self, jobs: Mapping[Any, Job]) -> Iterator[tuple[Any, Any]]:
        for tag, job in jobs.items():
            self.work.add(tag, evaluate, job)
        while len(self.work):
            yield from self._results()

    def _results(self) -> Iterator[tuple[Any, dict[str, Any]]]:
        """Yield (key, result) for results that arrive within a second. Raises BrokenExecutor, or WorkerLost on
        Ray, if a worker was killed repeatedly."""
        for key, future in self.work.arrived(1.0):
            yield key, future.result()
        if self._progress is not None:
            self._progress(self)

    def _job(self, number: int, values: dict[str, float]) -> Job:
        least = [self.least(stage) for stage in range(len(self.plan.stages) - 1)]
        plan = self.plan
        return Job(
            f"candidate-{number}",
            plan.config,
            values,
            plan.cells if self.sampler is None else [self.sampler.cell(number)],
            plan.stages,
            least,
            plan.config.search.hopeless,
            self.out / "policies",
            plan.fit,
        )

    def _whole(self, entry: Mapping[str, Any], cells: Iterable[tuple[int, int]], ticks: int) -> Job:
        """Return a job that runs a candidate with all these seeds at full length."""
        cells = tuple(cells)
        job = self._job(entry["candidate"], entry["values"] if entry["candidate"] else {})
        return replace(job, cells=cells, stages=[(ticks, len(cells))], least=[], hopeless=1.0)

    def least(self, stage: int) -> float:
        """Return the score needed to advance from a stage: a quantile of earlier candidates' scores."""
        reached = [e["stages"] for e in self.journal.of("candidate") if len(e["stages"]) > stage]
        if len(reached) < ENOUGH:
            return -np.inf
        scores = [stages[stage]["score"] for stages in reached]
        return float(np.quantile(scores, 1 - self.plan.config.search.promote))

    def ranked(self) -> list[dict[str, Any]]:
        """Return the candidates, best first: finalists by mean score over all seeds, other candidates by merit."""
        finals = {e["candidate"]: e for e in self.journal.of("final")}

        def key(entry: dict[str, Any]) -> tuple[float, float]:
            final = finals.get(entry["candidate"])
            return (1.0, 0.5 * (final["score"] + entry["score"])) if final else (0.0, merit(entry))

        return sorted(self.journal.of("candidate"), key=lambda e: (key(e), -e["candidate"]), reverse=True)

    def evaluated(self) -> list[dict[str, Any]]:
        """Return the candidates whose values produced a valid world, in order."""
        return sorted(
            (e for e in self.journal.of("candidate") if "refused" not in e), key=lambda e: int(e["candidate"])
        )

    def best(self) -> dict[str, Any]:
        return self.ranked()[0]

    @property
    def done(self) -> int:
        return len(self.journal.of("candidate"))

    @property
    def share(self) -> float:
        """The completed fraction of the search, in [0, 1]."""
        return self.budget.share

    def _forget(self, number: int) -> None:
        forget_trained(inside(self.out, self.out / "policies" / f"candidate-{number}"))

    def sweep(self) -> None:
        """Remove the policies of candidates that are unfinished or not among the best."""
        best = self.ranked()[: max(BEST, self.plan.config.search.finalists)]
        kept = {"candidate-0", *(f"candidate-{e['candidate']}" for e in best)}
        for folder in (self.out / "policies").glob("candidate-*"):
            if folder.name not in kept and folder.name.removeprefix("candidate-").isdigit():
                self._forget(int(folder.name.removeprefix("candidate-")))
