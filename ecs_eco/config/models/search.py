"""What runs ignore: settings of `ecs-eco search`, the measurements that it fits, and knobs of the page."""

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
    is_absent,
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
    """The range of a number, also as `[low, high]`.

    It takes whole numbers if value, low and high are whole.
    """

    search: Annotated[list[int | float], Field(min_length=2, max_length=2)] = about("[low, high]")
    scale: Literal["linear", "log"] = about(
        "whether equal steps are equal differences or equal factors", "linear"
    )


class Goal(Section):
    """One of several objectives."""

    of: What = about(
        "persistence, cycling, population, data, the name of a reporter, or module:function of "
        "the recorded series"
    )
    weight: Positive = quantity("its weight among the others", "1", 1.0)


class Confirm(Section):
    """The final test of the best world, on seeds that the search did not use."""

    world_seeds: Seeds = about("worlds for each training seed", 5)
    training_seeds: Seeds = about("training seeds, where policies are trained", 3)
    ticks: Ticks | None = quantity("length of a run; absent: as in the search", "ticks", None)


class Posterior(Section):
    """Approximate Bayesian computation: the optimisers abc and abc-smc, which sample the numbers with which
    the world is like the measurements of [data]."""

    particles: Annotated[int, Field(ge=10, le=100_000)] = about(
        "abc-smc: candidates of the first generation, drawn from the ranges", 100
    )
    keep: Annotated[float, Field(gt=0, lt=1)] | None = quantity(
        "share of the candidates (the nearest) that are the posterior, with abc-smc of `particles`; absent: "
        "0.5 with abc-smc, 0.1 with abc",
        "1",
        None,
    )
    stop: Share = quantity(
        "abc-smc: share of new candidates below which the posterior no longer improves: "
        "when fewer of a generation enter it, the search ends",
        "1",
        0.05,
    )


class Search(Section):
    """What a search varies, its objective and its budget: `ecs-eco search`."""

    objective: What | list[Goal] = about(
        "persistence, cycling, population, data (how near to the measurements of [data]), the name of a "
        "reporter, module:function, or a list with weights",
        "persistence",
    )
    wanted: dict[str, Positive] = table(
        "species = number of organisms, for the objective population; "
        "reporter = the mean wanted, if not as much as possible",
        dict,
    )
    persist: list[Name] = table(
        "species whose extinction ends a run; none: all but plants that come back from a seed rain", list
    )
    ticks: Ticks | None = quantity("length of a whole run; absent: the world's", "ticks", None)
    world_seeds: Seeds = about("world seeds of a candidate", 3)
    training_seeds: Seeds = about(
        "training seeds of a candidate, each with each world seed; 1 if nothing is trained", 2
    )
    policies: Literal["trained", "random", "untrained", "train", "train-once"] = about(
        "as in a run; train: each candidate trains its own; train-once: "
        "all use those trained in the world as written",
        "trained",
    )
    training_ticks: Ticks | None = quantity("length of a training; absent: the world's", "ticks", None)
    stages: Annotated[int, Field(ge=1, le=10)] = about(
        "stages of a candidate, from one short run to all runs", 3
    )
    first: Annotated[float, Field(gt=0, le=1)] = quantity(
        "length of the first stage's runs, as share of a whole one", "1", 0.25
    )
    promote: Annotated[float, Field(gt=0, le=1)] = quantity(
        "share of the candidates (the best) that advance to the next stage", "1", 0.4
    )
    hopeless: Share = quantity("share of lost runs at a stage beyond which a candidate is dropped", "1", 0.5)
    crowd: Annotated[float, Field(ge=1)] = quantity(
        "multiple of its initial organisms at which a run ends, as at an extinction", "1", 10.0
    )
    finalists: Annotated[int, Field(ge=1, le=50)] = about(
        "candidates that are tested on further seeds before the best is chosen", 4
    )
    confirm: Confirm = table("the last test", Confirm)
    posterior: Posterior = Field(
        default_factory=Posterior,
        exclude_if=lambda it: it == Posterior(),
        description="how abc and abc-smc sample",
    )
    seed: Annotated[int, Field(ge=0, lt=2**63)] = about("seed of the optimiser", 1)
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
    """An outside series: measurements that reports show beside a run, and that a search can fit."""

    file: Annotated[str, Field(min_length=1, max_length=1000)] = about(
        "a CSV file next to the world file: a header with the names of the columns, then a row for each time, "
        "evenly spaced"
    )
    time: Text | None = about("the column of the times; absent: the first one", None, exclude_if=is_absent)
    unit: Text | None = about(
        'unit of the times, as "year"; absent: the name of their column', None, exclude_if=is_absent
    )
    columns: dict[Text, Text] = Field(
        default_factory=dict,
        max_length=64,
        description="column = the species, or the reporter, that it "
        "is compared with; columns that are not here are compared with what they are named as",
    )
    ticks: Positive | None = quantity(
        "how long a unit of the times lasts in the world; absent: not known, and lags and amplitudes are "
        "compared period by period",
        "ticks",
        None,
        exclude_if=is_absent,
    )
    statistics: Annotated[list[Literal["period", "lag", "amplitude", "mean"]], Field(min_length=1)] = about(
        "what a search with the objective data compares: period of the cycle (where `ticks` is given), lags "
        "between the columns, amplitude and mean of each (mean where the units are the same)",
        ["period", "lag", "amplitude"],
    )


class Knob(Section):
    """A number that the page offers as a slider."""

    key: str = about("dotted key of a number that may change in a run, as species.deer.metabolism.basal")
    label: Annotated[str, Field(min_length=1, max_length=60)] | None = about(
        "what it is called in the page; absent: its key", None
    )
    min: Real = quantity("value at the left end of the slider", "unit of the key")
    max: Real = quantity("value at the right end", "unit of the key")
    unit: Annotated[str, Field(max_length=20)] | None = about("its unit; absent: that of its key", None)


class Viewer(Section):
    """What the viewer's page offers first: `ecs-eco watch`."""

    knobs: Annotated[list[Knob], Field(max_length=24)] = table(
        "numbers that the page offers as sliders, in this order", list
    )
