"""The plan of a search: parameters, ordered runs, stages, the seeds of finals and confirmation, and measurements
in the world's [data], a few of whose statistics are compared with those of runs."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, Self

import numpy as np

from ecs_eco.analysis.against import numbers_of
from ecs_eco.analysis.runs import Series
from ecs_eco.analysis.signature import cycle, period_of
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.lines import key_lines
from ecs_eco.config.measurements import Outside, outside_of
from ecs_eco.config.ranges import key_of, real_key
from ecs_eco.config.reading import read_toml
from ecs_eco.engine.errors import ConfigError, Problem, refusal

Cell = tuple[int, int]  # training seed, world seed
Stage = tuple[int, int]  # length of the runs [ticks], number of runs
FINALS, CONFIRMATION = 50_000, 100_000  # offsets of their seeds
TRAINED = ("train", "train-once")
SKIP = 0.1  # fraction of a run left out at its start when it is compared with measurements
Statistics = dict[str, float]


@dataclass(frozen=True)
class Parameter:
    """A parameter that the search varies."""

    name: str
    low: float
    high: float
    log: bool
    whole: bool
    start: float  # value in the world as written

    def tidy(self, value: float) -> float:
        """Return the value clipped to its range and rounded to four digits, as written to files."""
        value = min(max(float(f"{value:.4g}"), self.low), self.high)
        return round(value) if self.whole else float(value)


@dataclass(frozen=True)
class Fit:
    """Measurements to compare runs with, and their statistics: log10 values or fractions of a period.

    Attributes
    ----------
    outside : Outside
        The measurements.
    kinds : tuple of str
        Kinds of statistics compared: "period", "lag", "amplitude", "mean".
    observed : dict of str to float
        Statistics of the measurements.
    """

    outside: Outside
    kinds: tuple[str, ...]
    observed: Statistics
    sha256: str  # of the measurements

    def of(self, series: Series) -> Statistics | None:
        """Return the statistics of the last part of a run, as long as the measurements and sampled like them.

        Parameters
        ----------
        series : Series

        Returns
        -------
        dict of str to float or None
            None if the run is too short, or a species died out in that part.
        """
        x = sampled(series, self.outside)
        return None if x is None else statistics(x, list(self.outside.columns), self.outside, self.kinds)

    def differences(self, own: Mapping[str, float]) -> np.ndarray:
        """Return the differences between a run's statistics and those of the measurements.

        Parameters
        ----------
        own : Mapping of str to float
            Statistics as returned by `of`.

        Returns
        -------
        array of float64, shape (statistics,)
            Differences between lags are taken the shorter way around a period.
        """
        apart = [(name, own[name] - value) for name, value in self.observed.items()]
        return np.array([(d + 0.5) % 1 - 0.5 if name.startswith("lag ") else d for name, d in apart])


@dataclass(frozen=True)
class Plan:
    """A whole search, except its optimizer and budget."""

    config: WorldConfig
    parameters: tuple[Parameter, ...]
    ticks: int
    stages: tuple[Stage, ...]
    cells: tuple[Cell, ...]
    finals: tuple[Cell, ...]
    confirmation: tuple[Cell, ...]
    confirmation_ticks: int
    fit: Fit | None = None  # measurements, if the objective is "data"

    @property
    def start(self) -> dict[str, float]:
        return {p.name: p.start for p in self.parameters}

    def header(self) -> dict[str, Any]:
        """The settings that must not change when a search is resumed."""
        settings = self.config.search.model_dump(mode="json", exclude={"confirm", "finalists"})
        return {
            "world": self.config.name,
            "config_hash": self.config.config_hash,
            "search": json.loads(json.dumps(settings)),
            **({} if self.fit is None else {"data": self.fit.sha256}),
        }

    def sampling(self) -> Self:
        """Return the plan for sampling a posterior, in which each candidate has one run with its own seed."""
        trainings = sorted({training for training, _ in self.cells})
        return replace(
            self,
            stages=((self.ticks, 1),),
            cells=tuple((t, 0) for t in trainings),
            finals=(),
            confirmation=(),
        )


def plan_of(config: WorldConfig) -> Plan:
    """Return the plan in a world's [search]. Raises ConfigError if nothing varies or a range is invalid."""
    search = config.search
    if not search.ranges:
        allowed = (
            "a number written as { value = 0.014, search = [0.004, 0.02] }, an entry in [search.ranges], or "
            "--range KEY=LOW:HIGH"
        )
        raise refusal(("search", "ranges"), "nothing to vary", {}, allowed, source=config._source)
    config._code.require(config._source)
    problems = []
    if search.policies in TRAINED and not any(s.policy.thinks for s in config.species.values()):
        problems.append(
            Problem(("search", "policies"), "no species has a policy to train", search.policies, '"random"')
        )
    parameters = tuple(_parameter(config, name) for name in search.ranges)
    for p in parameters:
        problems += [*_refused(config, p, p.low), *_refused(config, p, p.high)]
    if problems:
        raise ConfigError([_placed(p, config) for p in problems], f"{config._source}: cannot search")
    trainings = search.training_seeds if search.policies in TRAINED else 1
    ticks = search.ticks or config.ticks
    cells = crossed(trainings, search.world_seeds, 0)
    retrained = search.confirm.training_seeds if search.policies in TRAINED else 1
    return Plan(
        config,
        parameters,
        ticks,
        stages(ticks, len(cells), search.stages, search.first),
        cells,
        crossed(trainings, search.world_seeds, FINALS),
        crossed(retrained, search.confirm.world_seeds, CONFIRMATION),
        search.confirm.ticks or ticks,
        fit_of(config, ticks),
    )


def _parameter(config: WorldConfig, name: str) -> Parameter:
    span = config.search.ranges[name]
    value = real_key(config.model_dump(), key_of(name))[1]
    low, high = span.search
    whole = all(isinstance(x, int) for x in (low, high, value))
    return Parameter(name, low, high, span.scale == "log", whole, min(max(value, low), high))


def _refused(config: WorldConfig, parameter: Parameter, end: float) -> Iterator[Problem]:
    """Yield the problem, if any, with the world at one end of a range."""
    try:
        load(config, {parameter.name: parameter.tidy(end)})
    except ConfigError as error:
        first = error.problems[0]
        fault = f"gives an invalid world: {first.path} {first.what}"
        span = list(config.search.ranges[parameter.name].search)
        yield Problem(("search", "ranges", parameter.name), fault, span, first.allowed)


def _placed(problem: Problem, config: WorldConfig) -> Problem:
    """Return the problem with its file and the line of the range."""
    path = config.folder / config._source
    if problem.source or not path.is_file():
        return problem if problem.source else problem.moved(source=config._source)
    lines = key_lines(read_toml(path)[0])
    places = [problem.key, (*key_of(str(problem.key[-1])), "search")]
    return problem.moved(source=config._source, line=next((lines[p] for p in places if p in lines), None))


def crossed(trainings: int, worlds: int, offset: int) -> tuple[Cell, ...]:
    """Return all pairs of training seed and world seed (from offset + 1); the first few differ in both."""
    pairs = ((k % trainings, (k // trainings + k % trainings) % worlds) for k in range(trainings * worlds))
    return tuple((offset + 1 + t, offset + 1 + w) for t, w in pairs)


def stages(ticks: int, runs: int, n: int, first: float) -> tuple[Stage, ...]:
    """Return stages that grow by equal factors, from one run of `first` × ticks to all runs at full length."""
    if n == 1:
        return ((ticks, runs),)
    steps = [i / (n - 1) for i in range(n)]
    return tuple((max(1, round(ticks * first ** (1 - s))), max(1, round(runs**s))) for s in steps)


def fit_of(config: WorldConfig, ticks: int) -> Fit | None:
    """Return the comparison for a world's goal "data", with runs of this many ticks, or None without this goal.
    Raises ConfigError if the measurements cannot be used or are longer than the runs."""
    if config.data is None or not any(of == "data" for of, _ in config.search.goals):
        return None
    names = [*config.species, *config.reporters]
    outside = outside_of(config.data.model_dump(), config.folder, names, config._source)
    least = 0.0 if outside.ticks is None else float(np.ptp(outside.times)) * outside.ticks + 1
    if (1 - SKIP) * ticks < least:
        raise refusal(
            ("search", "ticks"),
            "is shorter than the measurements in [data]",
            ticks,
            f"at least {int(np.ceil(least / (1 - SKIP))):,}",
            source=config._source,
        )
    x = np.stack(list(outside.columns.values()), 1)
    kinds = tuple(config.data.statistics)
    observed = statistics(x, list(outside.columns), outside, kinds)
    if not observed:
        allowed = "lag (with at least two columns), amplitude, mean, or period with data.ticks"
        raise refusal(
            ("data", "statistics"), "leaves nothing to compare", list(kinds), allowed, source=config._source
        )
    words = [repr((outside.ticks, kinds, list(outside.columns))).encode(), outside.times.tobytes()]
    return Fit(outside, kinds, observed, hashlib.sha256(b"".join([*words, x.tobytes()])).hexdigest())


def sampled(series: Series, outside: Outside) -> np.ndarray | None:
    """Return the last part of a run with the length and sampling rate of the measurements (in periods, if the
    length of their time unit is unknown), f64[samples, columns], or None if there is none."""
    n = np.stack([numbers_of(series, name) for name in outside.columns], 1)
    n = n[int(SKIP * len(n)) :]
    if not (np.isfinite(n).all() and (n >= 0).all() and n.any(0).all()):
        return None
    samples = len(outside.times)
    if outside.ticks is not None:
        step = outside.step * outside.ticks
    else:
        step = period_of(*n.T) / cycle(*outside.columns.values()).period
    at = len(n) - 1 - np.floor(step * np.arange(samples)[::-1]).astype(int)
    return n[at] if at[0] >= 0 and n[at].any(0).all() else None


def statistics(x: np.ndarray, names: list[str], outside: Outside, kinds: tuple[str, ...]) -> Statistics:
    """Return the statistics of series f64[samples, names]: period of their shared cycle [log10 of time
    units], lags between them [periods], amplitudes [log10], means [log10]."""
    found = cycle(*x.T)
    out: Statistics = {}
    if "period" in kinds and outside.ticks is not None:
        out["period"] = float(np.log10(found.period * outside.step))
    if "lag" in kinds:
        out |= {
            f"lag {a}, {b}": float((found.phases[names.index(b)] - found.phases[names.index(a)]) % 1)
            for a, b in combinations(names, 2)
        }
    if "amplitude" in kinds:
        out |= {f"amplitude {name}": float(swing) for name, swing in zip(names, found.swings, strict=True)}
    if "mean" in kinds:
        out |= {f"mean {name}": float(np.log10(mean)) for name, mean in zip(names, x.mean(0), strict=True)}
    return out
