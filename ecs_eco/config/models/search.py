"""Sections that do not affect runs: `ecs-eco search`, the measurements that it fits, and viewer knobs."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, PlainSerializer, WrapValidator

from ecs_eco.inputs.section import (
    Name,
    NamesCode,
    Positive,
    Real,
    Section,
    Share,
    about,
    function_name,
    quantity,
    table,
)

OBJECTIVES = ("persistence", "cycling", "population", "data")

Seeds = Annotated[int, Field(ge=1, le=1000)]
Ticks = Annotated[int, Field(ge=1, le=10**12)]


What = Annotated[
    str,
    NamesCode(),
    WrapValidator(lambda value, check: value if callable(value) else check(value)),
    PlainSerializer(lambda value, info: function_name(value) if info.mode == "json" else value),
]


class Range(Section):
    """The search range of a number, also written `[low, high]`.

    The search tries only integers if the value, low and high are integers.
    """

    search: Annotated[list[int | float], Field(min_length=2, max_length=2)] = about("[low, high]")
    scale: Literal["linear", "log"] = about(
        "whether equal steps are equal differences or equal ratios", "linear"
    )


class Goal(Section):
    """One of several objectives."""

    of: What = about(
        "persistence, cycling, population, data, the name of a reporter, or module:function, a function of "
        "the recorded series"
    )
    weight: Positive = quantity("weight relative to the other objectives", "1", 1.0)


class Confirm(Section):
    """The final test of the best world, on seeds not used in the search."""

    world_seeds: Seeds = about("worlds per training seed", 5)
    training_seeds: Seeds = about("training seeds, if policies are trained", 3)
    ticks: Ticks | None = quantity("length of a run; default: as in the search", "ticks", None)


class Posterior(Section):
    """Approximate Bayesian computation: the optimizers abc and abc-smc sample parameter values for which the
    world resembles the measurements in [data]."""

    particles: Annotated[int, Field(ge=10, le=100_000)] = about(
        "abc-smc: number of candidates in the first generation, drawn from the ranges", 100
    )
    keep: Annotated[float, Field(gt=0, lt=1)] | None = quantity(
        "proportion of the candidates, nearest first, that form the posterior (with abc-smc, of "
        "`particles`); default: 0.5 with abc-smc, 0.1 with abc",
        "1",
        None,
    )
    stop: Share = quantity(
        "abc-smc: the search ends when less than this proportion of a generation enters the posterior",
        "1",
        0.05,
    )


class Search(Section):
    """The parameters of a search, its objective and its budget: `ecs-eco search`."""

    objective: What | list[Goal] = about(
        "persistence, cycling, population, data (similarity to the measurements of [data]), the name of a "
        "reporter, module:function, or a list with weights",
        "persistence",
    )
    wanted: dict[str, Positive] = table(
        "species = number of organisms, for the objective population; reporter = target mean; a reporter "
        "without a target is maximized",
        dict,
    )
    persist: list[Name] = table(
        "species whose extinction ends a run; empty: all except plants that return through seed rain", list
    )
    ticks: Ticks | None = quantity("length of a full run; default: the world's `ticks`", "ticks", None)
    world_seeds: Seeds = about("world seeds per candidate", 3)
    training_seeds: Seeds = about(
        "training seeds per candidate, each combined with each world seed; 1 without training", 2
    )
    policies: Literal["trained", "random", "untrained", "train", "train-once"] = about(
        "policies, as in a run; train: each candidate trains its own; train-once: all candidates use "
        "policies trained in the unchanged world",
        "trained",
    )
    training_ticks: Ticks | None = quantity(
        "length of training; default: the world's `training.ticks`", "ticks", None
    )
    stages: Annotated[int, Field(ge=1, le=10)] = about(
        "stages in which a candidate is tested, from a single short run to all runs", 3
    )
    first: Annotated[float, Field(gt=0, le=1)] = quantity(
        "length of the first stage's runs, as a fraction of a full run", "1", 0.25
    )
    promote: Annotated[float, Field(gt=0, le=1)] = quantity(
        "proportion of the candidates, best first, that advance to the next stage", "1", 0.4
    )
    hopeless: Share = quantity(
        "proportion of failed runs in a stage above which a candidate is dropped", "1", 0.5
    )
    crowd: Annotated[float, Field(ge=1)] = quantity(
        "a run ends when the number of organisms and objects exceeds this multiple of its initial value",
        "1",
        10.0,
    )
    finalists: Annotated[int, Field(ge=1, le=50)] = about(
        "candidates tested on further seeds before the best is chosen", 4
    )
    confirm: Confirm = table("the final test", Confirm)
    posterior: Posterior = table("settings of abc and abc-smc", Posterior, omit=True)
    seed: Annotated[int, Field(ge=0, lt=2**63)] = about("seed of the optimizer", 1)
    ranges: dict[
        str, Annotated[Range, BeforeValidator(lambda v: {"search": v} if isinstance(v, list) else v)]
    ] = table("dotted key = [low, high], or a table with scale", dict)

    @property
    def goals(self) -> list[tuple[Any, float]]:
        """The objectives, with weights that sum to 1."""
        goals = (
            [(g.of, g.weight) for g in self.objective]
            if isinstance(self.objective, list)
            else [(self.objective, 1.0)]
        )
        total = sum(weight for _, weight in goals)
        return [(of, weight / total) for of, weight in goals]


Text = Annotated[str, Field(min_length=1, max_length=200)]


class Data(Section):
    """An external series: measurements that reports show next to a run's results, and to which a search can
    fit a world."""

    file: Annotated[str, Field(min_length=1, max_length=1000)] = about(
        "a CSV file next to the world file: a header with column names, then a row for each of the evenly "
        "spaced times"
    )
    time: Text | None = about("the column of times; default: the first column", omit=True)
    unit: Text | None = about(
        'unit of the times, such as "year"; default: the name of their column', omit=True
    )
    columns: dict[Text, Text] = table(
        "column = the species or reporter that it is compared with; unlisted columns are compared with the "
        "species or reporter of the same name",
        dict,
        max_length=64,
    )
    ticks: Positive | None = quantity(
        "length of one unit of time; default: unknown, so lags and amplitudes are compared period by period",
        "ticks",
        omit=True,
    )
    statistics: Annotated[list[Literal["period", "lag", "amplitude", "mean"]], Field(min_length=1)] = about(
        "features that the objective data compares: period of the cycle (if `ticks` is given), lags between "
        "columns, and amplitude and mean of each column (the mean only if the units are the same)",
        ["period", "lag", "amplitude"],
    )


class Knob(Section):
    """A number that the viewer offers as a slider."""

    key: str = about(
        "dotted key of a number that may change during a run, such as species.deer.metabolism.basal"
    )
    label: Annotated[str, Field(min_length=1, max_length=60)] | None = about(
        "label in the viewer; default: its key", None
    )
    min: Real = quantity("value at the left end of the slider", "unit of the key")
    max: Real = quantity("value at the right end", "unit of the key")
    unit: Annotated[str, Field(max_length=20)] | None = about("unit; default: the unit of its key", None)


class Viewer(Section):
    """Controls that the viewer (`ecs-eco watch`) shows first."""

    knobs: Annotated[list[Knob], Field(max_length=24)] = table(
        "numbers that the viewer offers as sliders, in this order", list
    )
