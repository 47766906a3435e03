"""The plan of a search: parameters, ordered runs, stages, and the seeds of finals and confirmation."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Self

from ecs_eco.config import WorldConfig, load
from ecs_eco.config.lines import key_lines
from ecs_eco.config.ranges import key_of, real_key
from ecs_eco.engine.errors import ConfigError, Problem, refusal
from ecs_eco.lab.searching.fit import Fit, fit_of

Cell = tuple[int, int]  # training seed, world seed
Stage = tuple[int, int]  # length of the runs [ticks], number of runs
FINALS, CONFIRMATION = 50_000, 100_000  # offsets of their seeds
TRAINED = ("train", "train-once")


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
    lines = key_lines(path.read_text(encoding="utf-8"))
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
