"""The evaluation of a candidate, in its own process: stage after stage, dropped once it is hopeless.

Its outcomes depend on the candidate's values and seeds alone; the stage that it reaches,
also on earlier candidates.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.config import WorldConfig, load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.experiments.trained import train_or_find
from ecs_eco.search.fit import Fit

STEP = 25  # ticks between two checks for extinctions


@dataclass(frozen=True)
class Job:
    """A candidate, and how it is to be evaluated."""

    name: str  # of its policies' folder
    config: WorldConfig
    values: dict[str, Any]
    cells: Sequence[tuple[int, int]]
    stages: Sequence[tuple[int, int]]
    least: Sequence[float]  # the score required by each stage but the last
    hopeless: float  # share of runs lost beyond which it ends
    policies: Path  # where policies that are trained are kept
    fit: Fit | None = None  # the measurements that it is compared with


def evaluate(job: Job) -> dict[str, Any]:
    """Outcomes by stage, the last stage, its score, and seconds; "refused" if the values make no valid world.

    "failed" is the error raised by the user's own code.
    """
    begin, worked = time.perf_counter(), time.process_time()
    try:
        result = _evaluate(load(job.config, job.values), job)
    except ConfigError as error:
        result = {"stage": 0, "score": 0.0, "stages": [], "refused": str(error)}
    except Exception as error:
        result = {"stage": 0, "score": 0.0, "stages": [], "failed": f"{type(error).__name__}: {error}"}
    seconds, cpu = time.perf_counter() - begin, time.process_time() - worked
    return result | {"seconds": round(seconds, 3), "cpu": round(cpu, 3)}


def _evaluate(config: WorldConfig, job: Job) -> dict[str, Any]:
    lives: list[Life] = []
    stages: list[dict[str, Any]] = []
    for stage, (ticks, n) in enumerate(job.stages):
        lives += [Life(config, job, cell) for cell in job.cells[len(lives) : n]]
        runs = _stage(lives, ticks, job.hopeless)
        score = sum(r["score"] for r in runs) / len(runs)
        lost = sum(r["extinct"] is not None for r in runs)
        stages.append({"ticks": ticks, "score": score, "lost": lost, "runs": runs})
        if lost > job.hopeless * n or (stage < len(job.least) and score < job.least[stage]):
            break
    return {"stage": len(stages) - 1, "score": stages[-1]["score"], "stages": stages}


def _stage(lives: Sequence[Life], ticks: int, hopeless: float) -> list[dict[str, Any]]:
    """Outcomes of the runs, until so many are lost that the rest does not matter."""
    runs: list[dict[str, Any]] = []
    for life in lives:
        runs.append(life.until(ticks))
        if sum(r["extinct"] is not None for r in runs) > hopeless * len(lives):
            break
    return runs


class Life:
    """One run of a candidate, which later stages continue."""

    def __init__(self, config: WorldConfig, job: Job, cell: tuple[int, int]) -> None:
        self.config, self.job, self.cell = config, job, cell
        self.persist = persisting(config)
        self.world: Any = None
        self.died: tuple[int, str] | None = None  # tick, and who
        self.seconds = 0.0

    def until(self, ticks: int) -> dict[str, Any]:
        """Run to a tick or the first extinction; return how long all lived, what died out, and the score.

        In a run of full length a species without births in the later half counts as lost with its last birth.
        """
        from ecs_eco.analysis.runs import load_series
        from ecs_eco.search.objectives import objective

        begin = time.perf_counter()
        try:
            if self.world is None:
                self._begin()
            while self.died is None and self.world.tick < ticks:
                self._go(min(STEP, ticks - self.world.tick))
        except FloatingPointError:
            self.died = self.world.tick if self.world is not None else 0, "numbers that are not finite"
        if self.died is None and ticks == self.job.stages[-1][0]:
            self.died = self._last_birth(ticks)
        lived = ticks if self.died is None else min(self.died[0], ticks)
        score, goal, fit = lived / ticks, None, self.job.fit
        own: dict[str, Any] = {} if fit is None else {"statistics": None}
        if self.died is None:
            series = load_series(self.world.series())
            goal = objective(self.config.search, series, self.persist, self.config.function, fit)
            score += goal
            if fit is not None:
                own["statistics"] = fit.of(series)
        self.seconds += time.perf_counter() - begin
        return {
            "training": self.cell[0],
            "world": self.cell[1],
            "lived": lived,
            "extinct": self.died and self.died[1],
            "score": score,
            "goal": goal,
            **own,
            "seconds": round(self.seconds, 3),
        }

    def _begin(self) -> None:
        from ecs_eco.ecosystem import World

        training_seed, seed = self.cell
        self.world = World.from_config(
            self.config, seed=seed, policies=policies(self.config, self.job, training_seed)
        )
        self.most = self.config.search.crowd * max(1, sum(t.n for t in self.world.tables.values()))

    def _go(self, ticks: int) -> None:
        from ecs_eco.analysis.runs import load_series

        self.world.run(ticks)
        gone = [s for s in self.persist if self.world.tables[s].n == 0]
        if gone:
            series = load_series(self.world.series())
            when = {s: int(series.extinct[series.index(s)]) for s in gone}
            first = min(gone, key=lambda s: when[s])
            self.died = when[first], first
        elif sum(t.n for t in self.world.tables.values()) > self.most:
            self.died = self.world.tick, "too many"

    def _last_birth(self, ticks: int) -> tuple[int, str] | None:
        """Return when the first species to stop breeding had its last birth, and its name; None where all
        that can breed have births in the later half: who only outlives the run does not persist."""
        from ecs_eco.analysis.runs import load_series

        series = load_series(self.world.series())
        last = {}
        for name in self.persist:
            if self.config.species[name].reproduction is not None:
                born = np.flatnonzero(series.columns["births"][:, series.index(name)])
                last[name] = int(series.ticks[born[-1]]) if born.size else 0
        first = min(last, key=lambda name: last[name], default=None)
        return None if first is None or last[first] > ticks / 2 else (last[first], f"{first}, without births")


def persisting(config: WorldConfig) -> list[str]:
    """The species whose extinction ends a run: those that [search] names, or all that cannot come back."""
    if config.search.persist:
        return list(config.search.persist)
    return [
        name for name, s in config.species.items() if s.count and not getattr(s.reproduction, "seed_rain", 0)
    ]


def policies(config: WorldConfig, job: Job, seed: int) -> Any:
    """The initial policies of a run; trained here if required and not done yet."""
    kind = job.config.search.policies
    if kind not in ("train", "train-once"):
        return kind
    owner, trained_in = (job.name, config) if kind == "train" else ("start", job.config)
    folder = job.policies / owner / f"training-{seed}"
    return str(train_or_find(folder, trained_in, seed, job.config.search.training_ticks))
