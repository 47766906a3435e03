"""The course of a search: ask, evaluate, tell until its budget is used; then finals and confirmation. Its entire
state is in its folder."""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.engine.errors import ForeignFile, refusal
from ecs_eco.lab.jobs import forget_trained
from ecs_eco.lab.searching.evaluate import Job, evaluate
from ecs_eco.lab.searching.journal import Entry, begin
from ecs_eco.lab.searching.optimise import Optimiser, merit
from ecs_eco.lab.searching.plan import Cell, Plan
from ecs_eco.lab.searching.sampler import SAMPLERS, Sampler
from ecs_eco.lab.work import Work
from ecs_eco.record.container import inside

BEST = 5  # number of worlds written
ENOUGH = 4  # number of candidates that a stage needs before it requires a score
# fraction of the time reserved for finals and confirmation, before a run at full length has been timed
FIRST_RESERVE = 0.25
MOST_RESERVE = 0.6  # maximum fraction reserved, however long such runs take
Progress = Callable[["Search"], None]


class Search:
    """One search: its plan, journal, running jobs, and budget, which includes earlier calls."""

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
        self.seconds = None if budget is None else budget * 60
        self.trials, self.cpu = trials, cpu
        self._before = max((float(e["at"]) for e in self.journal.entries), default=0.0)
        self._begun = time.monotonic()

    def run(self) -> None:
        """Search and, unless this is a sampler, compare and confirm the best candidates on fresh seeds."""
        self._candidates()
        if self.sampler is not None:
            return
        self.phase = "finals"
        self._test("final", [(e, self.plan.finals, self.plan.ticks) for e in self._finalists()])
        self.phase, cells = "confirming", self.plan.confirmation
        worlds = self.ranked()[0], self.evaluated()[0]  # the best, and the world as written
        self._test(
            "confirmation", [(e, (cell,), self.plan.confirmation_ticks) for e in worlds for cell in cells]
        )

    def _candidates(self) -> None:
        known = {e["candidate"] for e in self.journal.of("candidate")}
        numbers = (number for number in count() if number not in known)  # candidate 0 is the world as written
        coming, waiting, sampler = next(numbers), True, self.sampler
        while waiting or len(self.work):
            while waiting and len(self.work) < self.workers and (sampler is None or sampler.ready(coming)):
                is_last = sampler is not None and sampler.finished(coming)
                waiting = self._allows_another(len(self.work)) and not is_last
                if waiting:
                    values = self.proposer.ask(coming) if coming else self.plan.start
                    self.proposed[coming] = values
                    least = [self.least(stage) for stage in range(len(self.plan.stages) - 1)]
                    own = self.plan if sampler is None else replace(self.plan, cells=(sampler.cell(coming),))
                    self.work.add(coming, evaluate, self._job(coming, values, own, least))
                    coming = next(numbers)
            for number, result in self._results():
                self._tell(number, self.proposed.pop(number), result)
            if len(self.work) and self._is_over():
                self.work.stop()
                return

    def _tell(self, number: int, values: dict[str, float], result: dict[str, Any]) -> None:
        if number == 0 and ("failed" in result or "refused" in result):
            fault = f"cannot be evaluated: {result.get('failed') or result['refused']}"
            raise refusal((), fault, source="the world as written")
        entry = self.journal.add("candidate", candidate=number, values=values, **result, at=self.elapsed)
        self.proposer.tell(number, values, merit(entry))
        if number and entry not in self.ranked()[: max(BEST, self.plan.config.search.finalists)]:
            self._forget(number)

    def _finalists(self) -> list[dict[str, Any]]:
        """Return the best candidates that passed all runs; none if there is only one."""
        last = len(self.plan.stages) - 1
        best = [e for e in self.ranked() if e["stage"] == last][: self.plan.config.search.finalists]
        return best if len(best) > 1 else []

    def _test(self, kind: str, tests: Iterable[tuple[Entry, Sequence[Cell], int]]) -> None:
        """Run candidates with all of these seeds for these ticks, except those in the journal."""
        known = {(e["candidate"], *e.get("cell", ())) for e in self.journal.of(kind)}
        for entry, cells, ticks in tests:
            key = (entry["candidate"], *(cells[0] if kind == "confirmation" else ()))
            if key not in known:
                known.add(key)
                plan = replace(self.plan, cells=tuple(cells), stages=((ticks, len(cells)),))
                self.work.add(key, evaluate, self._job(entry["candidate"], entry["values"], plan, None))
        while len(self.work):
            for (number, *cell), result in self._results():
                own = {"cell": cell} if cell else {}
                self.journal.add(kind, candidate=number, **own, **result, at=self.elapsed)

    def _results(self) -> Iterator[tuple[Any, dict[str, Any]]]:
        """Yield (key, result) for results that arrive within a second. Raises BrokenExecutor, or WorkerLost on
        Ray, if a worker was killed repeatedly."""
        for key, future in self.work.arrived(1.0):
            yield key, future.result()
        if self._progress is not None:
            self._progress(self)

    def _job(self, number: int, values: dict[str, float], plan: Plan, least: Sequence[float] | None) -> Job:
        return Job(f"candidate-{number}", plan, values if number else {}, least, self.out / "policies")

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

    @property
    def done(self) -> int:
        return len(self.journal.of("candidate"))

    @property
    def elapsed(self) -> float:
        """The elapsed time of the search [s]."""
        return round(self._before + time.monotonic() - self._begun, 3)

    @property
    def worked(self) -> float:
        """The CPU time of candidates [s]."""
        return float(sum(e["cpu"] for e in self.journal.of("candidate")))

    @property
    def share(self) -> float:
        """The completed fraction of the search, in [0, 1]."""
        parts = ((self.done, self.trials), (self.elapsed, self.seconds), (self.worked, self.cpu))
        return min(1.0, max((used / whole for used, whole in parts if whole), default=0.0))

    def _allows_another(self, running: int) -> bool:
        """Return whether another candidate can begin; the first always can."""
        n = self.done + running
        if (self.trials is not None and n >= self.trials) or (
            self.cpu is not None and self.worked >= self.cpu
        ):
            return False
        usual = float(np.median([e["seconds"] for e in self.journal.of("candidate")] or [0.0]))
        return n == 0 or self.seconds is None or self.elapsed < self.seconds - self._reserve() - usual

    def _is_over(self) -> bool:
        """Return whether no time is left for candidates; False until there is a result."""
        return self.seconds is not None and self.done > 0 and self.elapsed > self.seconds - self._reserve()

    def _reserve(self) -> float:
        """Return the time to reserve for finals and confirmation [s]."""
        seconds, plan = self.seconds or 0.0, self.plan
        whole = [e for e in self.journal.of("candidate") if len(e["stages"]) == len(plan.stages)]
        if not whole:
            return FIRST_RESERVE * seconds
        # of a run at full length, with its share of training [s]
        run = float(np.median([e["seconds"] / len(e["stages"][-1]["runs"]) for e in whole]))
        confirmation = len(plan.confirmation) * plan.confirmation_ticks / plan.ticks
        runs = len(self._finalists()) * len(plan.finals) + confirmation
        return min(1.15 * runs * run / self.workers, MOST_RESERVE * seconds)

    def _forget(self, number: int) -> None:
        forget_trained(inside(self.out, self.out / "policies" / f"candidate-{number}"))

    def sweep(self) -> None:
        """Remove the policies of candidates that are unfinished or not among the best."""
        best = self.ranked()[: max(BEST, self.plan.config.search.finalists)]
        kept = {"candidate-0", *(f"candidate-{e['candidate']}" for e in best)}
        for folder in (self.out / "policies").glob("candidate-*"):
            if folder.name not in kept and folder.name.removeprefix("candidate-").isdigit():
                self._forget(int(folder.name.removeprefix("candidate-")))
