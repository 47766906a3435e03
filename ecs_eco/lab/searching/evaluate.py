"""Evaluate a candidate in its own process, stage by stage, and stop once it is hopeless. Outcomes depend only on
its values and seeds; the stage that it reaches also depends on earlier candidates."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.cycles import cycle_statistics
from ecs_eco.analysis.runs import Series, load_series
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.models.search import Search
from ecs_eco.engine.errors import ConfigError
from ecs_eco.inputs.code import handed_over
from ecs_eco.lab.jobs import train_or_find
from ecs_eco.lab.searching.plan import Fit, Plan


def objective(
    search: Search,
    series: Series,
    persist: Sequence[str],
    find: Callable[[Any], Any] = handed_over,
    fit: Fit | None = None,
) -> float:
    """Return the weighted mean of a search's goals for a run in which all species survived; `find` resolves
    "module:name", and `fit` is the comparison for the goal "data"."""
    scores = [weight * score(of, series, persist, search.wanted, find, fit) for of, weight in search.goals]
    return float(sum(scores))


def likeness(series: Series, fit: Fit) -> float:
    """Return 1 / (1 + RMS difference from the measured statistics [tenths]), or 0 if the run is too short."""
    own = fit.of(series)
    if own is None:
        return 0.0
    return float(1 / (1 + 10 * np.sqrt(np.mean(fit.differences(own) ** 2))))


def score(
    of: str | Callable[[Series], float],
    series: Series,
    persist: Sequence[str],
    wanted: Mapping[str, float],
    find: Callable[[Any], Any] = handed_over,
    fit: Fit | None = None,
) -> float:
    """Return a run's score for one goal; of functions and reporters, clipped to ±1e6, with 0 for NaN."""
    if of == "data" and fit is not None:
        return likeness(series, fit)
    if of == "persistence":
        return distance(series, persist)
    if of == "cycling":
        return cycling(series, persist)
    if of == "population":
        return population(series, {name: n for name, n in wanted.items() if name in series.species})
    if isinstance(of, str) and of in series.reporters:
        return _clipped(reported(series, of, wanted.get(of)))
    return _clipped(float(find(of)(series)))


def _clipped(value: float) -> float:
    return float(np.clip(value, -1e6, 1e6)) if np.isfinite(value) else 0.0


def distance(series: Series, persist: Sequence[str]) -> float:
    """Return the distance from extinction, ln(1 + minimum n) / ln(1 + mean n), of the species closest to it."""
    distances = [np.log1p(n.min()) / np.log1p(n.mean()) for s in persist if (n := series.of(s)).any()]
    return float(min(distances, default=0.0))


def cycling(series: Series, persist: Sequence[str]) -> float:
    """Return the mean over species of ln(p) / ln(0.05), at most 1, with the spectral peak's p against AR(1)."""
    statistics = cycle_statistics(series, n_boot=199)
    p = [statistics.p_ar1.get(s) or 1.0 for s in persist]
    return float(np.mean(np.minimum(1.0, np.log(p) / np.log(0.05))))


def population(series: Series, wanted: Mapping[str, float]) -> float:
    """Return the mean over species of n / wanted or wanted / n, whichever is smaller, where n is the mean
    number in the second half of the run."""
    half = len(series.ticks) // 2
    n = np.array([series.of(s)[half:].mean() for s in wanted])
    w = np.array(list(wanted.values()))
    return float(np.mean(np.minimum(n / w, w / np.maximum(n, 1e-9))))


def reported(series: Series, name: str, wanted: float | None) -> float:
    """Return a reporter's mean over species and the second half of a run. With a target, return the closeness
    of this mean to it: their ratio, at most 1, or 0 if the mean is not above 0."""
    values = series.columns[name][len(series.ticks) // 2 :]
    mean = float(values[np.isfinite(values)].mean()) if np.isfinite(values).any() else float("nan")
    if wanted is None:
        return mean
    return max(0.0, min(mean / wanted, wanted / mean if mean > 0 else 0.0))


STEP = 25  # ticks between checks for extinctions


@dataclass(frozen=True)
class Job:
    """A candidate and the plan of its evaluation."""

    name: str  # name of its policy folder
    plan: Plan  # with the candidate's own seeds and stages
    values: dict[str, Any]
    least: Sequence[float] | None  # score required at each stage except the last; None: no run is left out
    policies: Path  # folder of trained policies


def evaluate(job: Job) -> dict[str, Any]:
    """Return the outcomes by stage, the last stage, its score, and the seconds used, with "refused" if the
    values do not produce a valid world, or "failed" if the user's code raised an error."""
    begin, worked = time.perf_counter(), time.process_time()
    try:
        result = _evaluate(load(job.plan.config, job.values), job)
    except ConfigError as error:
        result = {"stage": 0, "score": 0.0, "stages": [], "refused": str(error)}
    except Exception as error:
        result = {"stage": 0, "score": 0.0, "stages": [], "failed": f"{type(error).__name__}: {error}"}
    seconds, cpu = time.perf_counter() - begin, time.process_time() - worked
    return result | {"seconds": round(seconds, 3), "cpu": round(cpu, 3)}


class Life:
    """One run of a candidate, continued in later stages."""

    def __init__(self, config: WorldConfig, job: Job, cell: tuple[int, int]) -> None:
        self.config, self.job, self.cell = config, job, cell
        self.persist = persisting(config)
        self.world: Any = None
        self.died: tuple[int, str] | None = None  # tick, and species
        self.seconds = 0.0

    def until(self, ticks: int) -> dict[str, Any]:
        """Run to a tick or the first extinction; return how long all species lived, which species died out,
        and the score. In a full-length run, a species without births in the second half counts as extinct
        from its last birth on."""
        begin = time.perf_counter()
        try:
            if self.world is None:
                self._begin()
            while self.died is None and self.world.tick < ticks:
                self._go(min(STEP, ticks - self.world.tick))
        except FloatingPointError:
            self.died = self.world.tick if self.world is not None else 0, "numbers that are not finite"
        if self.died is None and ticks == self.job.plan.stages[-1][0]:
            self.died = self._last_birth(ticks)
        lived = ticks if self.died is None else min(self.died[0], ticks)
        score, goal, fit = lived / ticks, None, self.job.plan.fit
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
        search, policies = self.config.search, str(self.config.search.policies)
        if policies in ("train", "train-once"):
            own = policies == "train"
            owner, trained_in = (self.job.name, self.config) if own else ("start", self.job.plan.config)
            folder = self.job.policies / owner / f"training-{training_seed}"
            policies = str(train_or_find(folder, trained_in, training_seed, search.training_ticks))
        self.world = World.from_config(self.config, seed=seed, policies=policies)
        self.most = self.config.search.crowd * max(1, sum(t.n for t in self.world.tables.values()))

    def _go(self, ticks: int) -> None:
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
        """Return the tick of the last birth and the name of the first species to stop breeding, or None if
        all species that can breed do so in the second half: one that only outlives the run does not persist."""
        series = load_series(self.world.series())
        last = {}
        for name in self.persist:
            if self.config.species[name].reproduction is not None:
                born = np.flatnonzero(series.columns["births"][:, series.index(name)])
                last[name] = int(series.ticks[born[-1]]) if born.size else 0
        first = min(last, key=lambda name: last[name], default=None)
        return None if first is None or last[first] > ticks / 2 else (last[first], f"{first}, without births")


def _evaluate(config: WorldConfig, job: Job) -> dict[str, Any]:
    least, hopeless = ((), 1.0) if job.least is None else (job.least, job.plan.config.search.hopeless)
    lives: list[Life] = []
    stages: list[dict[str, Any]] = []
    for stage, (ticks, n) in enumerate(job.plan.stages):
        lives += [Life(config, job, cell) for cell in job.plan.cells[len(lives) : n]]
        runs: list[dict[str, Any]] = []
        for life in lives:
            runs.append(life.until(ticks))
            lost = sum(r["extinct"] is not None for r in runs)
            if lost > hopeless * len(lives):
                break
        score = sum(r["score"] for r in runs) / len(runs)
        stages.append({"ticks": ticks, "score": score, "lost": lost, "runs": runs})
        if lost > hopeless * n or (stage < len(least) and score < least[stage]):
            break
    return {"stage": len(stages) - 1, "score": stages[-1]["score"], "stages": stages}


def persisting(config: WorldConfig) -> list[str]:
    """Return the species whose extinction ends a run: those set in [search], or all that cannot come back."""
    if config.search.persist:
        return list(config.search.persist)
    return [
        name for name, s in config.species.items() if s.count and not getattr(s.reproduction, "seed_rain", 0)
    ]
