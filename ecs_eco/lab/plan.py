"""plan.toml: a world, the values to vary, seeds and treatments, as written, before worlds are built."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Tag, ValidationError

from ecs_eco.config import WorldConfig
from ecs_eco.config.document import Document
from ecs_eco.config.explain import problems_of
from ecs_eco.config.former import rename
from ecs_eco.config.models.search import Range, Ticks
from ecs_eco.config.ranges import Key, key_of, name_of, real_key
from ecs_eco.config.reading import read_toml
from ecs_eco.engine.errors import ConfigError, Problem
from ecs_eco.inputs.section import Section, about, quantity, table

Seed = Annotated[int, Field(ge=0, lt=2**63)]
Seeds = Annotated[
    Annotated[int, Field(ge=1, le=100_000), Tag("number")]
    | Annotated[list[Seed], Field(min_length=1, max_length=100_000), Tag("names")],
    Discriminator(lambda value: "names" if isinstance(value, list) else "number"),
]
Names = list[str]
Values = list[Any]
Points = list[dict[str, Any]]
RANGES = ("sample", "ranges")
MOST_JOBS = 100_000


class Sample(Section):
    """Points drawn from any number of ranges: spread evenly, or as a sensitivity analysis needs them."""

    points: int = quantity(
        "points; sobol: base points, a power of 2, each with one point more per range and another; morris: "
        "walks, each with one point more than there are ranges",
        "1",
        ge=1,
        le=MOST_JOBS,
    )
    design: Literal["lhs", "sobol", "morris"] = about("lhs: a Latin hypercube", "lhs", omit=True)
    seed: Seed = about("seed for drawing the points", 0)
    ranges: dict[str, Range] = about("[low, high] for each value, by dotted key")

    @property
    def size(self) -> int:
        return (
            self.points
            * {"lhs": 1, "sobol": len(self.ranges) + 2, "morris": len(self.ranges) + 1}[self.design]
        )

    @property
    def problem(self) -> dict[str, Any]:
        """The ranges in SALib's form."""
        return {
            "num_vars": len(self.ranges),
            "names": [*self.ranges],
            "bounds": [[0.0, 1.0]] * len(self.ranges),
        }

    def shares(self) -> np.ndarray:
        """Return all points, as fractions of the ranges (McKay, Beckman and Conover 1979; Saltelli et al. 2010;
        Morris 1991)."""
        if self.design == "lhs":
            from scipy.stats import qmc

            return qmc.LatinHypercube(len(self.ranges), rng=self.seed).random(self.points)
        more = {"calc_second_order": False} if self.design == "sobol" else {}
        sample = import_module(f"SALib.sample.{self.design}").sample
        return np.asarray(sample(self.problem, self.points, seed=self.seed, **more))


class Plan(Section):
    """A whole plan file; the values of grid, sample and list are fully crossed."""

    world: str = about(
        "path to a world file, relative to the plan, or name of a shipped world; in Python, also a dict or "
        "WorldConfig"
    )
    title: str = about("title of the report", "")
    ticks: Ticks | None = quantity("length of a run; default: the world's `ticks`", "ticks", None)
    world_seeds: Seeds = about("number of world seeds, counted from 1, or a list of seeds", 1)
    training_seeds: Seeds | None = about(
        "number of training seeds, counted from 1, or a list of seeds; default: no training", None
    )
    retrain: bool = about(
        "whether policies are trained separately for each set of values and each treatment that changes "
        "values, instead of once in the unchanged world",
        False,
    )
    policies: str = about(
        "initial policies of runs without training: trained, random, untrained, or a folder relative to "
        "the plan",
        "trained",
    )
    until: Annotated[Names, BeforeValidator(lambda v: [v] if isinstance(v, str) else v)] = table(
        'conditions that end a run, over species\' numbers and reporters, such as "wolf == 0"',
        list,
        omit=True,
    )
    from_tick: Annotated[int, Field(ge=0)] = quantity(
        "first tick that counts for means, cycles, births and deaths (burn-in)", "ticks", 0, omit=True
    )
    treatments: Names = about(
        "treatments in addition to the unchanged world, as for `ecs-eco compare --treatment`", []
    )
    reporters: dict[str, Any] = about("reporters in addition to the world's, in the same format", {})
    set: dict[str, Any] = about("values for all runs, by dotted key", {})
    grid: dict[str, Values] | None = about("values of each key, in all combinations", None)
    sample: Sample | None = about("numbers drawn from ranges", None, former="latin_hypercube")
    list: Points | None = about("sets of values that vary together", None)
    checkpoint_every: Ticks | None = quantity(
        "ticks between a run's checkpoints; default: 20 per run, at least 2,000 ticks apart", "ticks", None
    )

    def seeds(self, kind: str) -> Sequence[int]:
        """Return the "world" or "training" seeds."""
        given = self.training_seeds if kind == "training" else self.world_seeds
        return tuple(range(1, given + 1)) if isinstance(given, int) else tuple(given or ())


@dataclass(frozen=True)
class PlanFile:
    """A plan after reading; its values have dotted keys, however the file nests them."""

    plan: Plan
    document: Document
    written: Mapping[Key, Key]  # key of a value here → its key in the file

    @property
    def notes(self) -> list[str]:
        """The current name of each key that the file gives under a former name."""
        return [
            f"{now[0]} is the present name of {old[0]}" for now, old in self.written.items() if len(now) == 1
        ]

    def refused(self, problems: Iterable[Problem]) -> ConfigError:
        return _refused(self.document, self.written, problems)


def read_plan(
    plan: str | Path | Mapping[str, Any], design: str | None = None, seeds: int | None = None
) -> PlanFile:
    """Read a plan from a file, or from a dict whose paths are relative to the working folder; `design` replaces
    the design of its ranges, `seeds` its world seeds. Raises ConfigError if the plan is invalid."""
    if isinstance(plan, Mapping):
        document = Document(dict(plan), "plan", Path())
    else:
        path = Path(plan)
        try:
            text, data = read_toml(path)
        except ConfigError as error:
            problems = [p.moved(source="PLAN") if p.source == "WORLD" else p for p in error.problems]
            raise ConfigError(problems, error.title or f"cannot read the plan {path}") from None
        document = Document(data, path.name, path.parent, text)
    data, written = _flattened(document.data)
    if isinstance(data.get("world"), Mapping | WorldConfig):
        data["world"] = "world"  # `design` reads the world from the document
    data |= {} if seeds is None else {"world_seeds": seeds}
    if design is not None and isinstance(data.get("sample", {}), Mapping):
        data["sample"] = {**data.get("sample", {}), "design": design}
    try:
        model = Plan.model_validate(data)
    except ValidationError as error:
        raise _refused(document, written, problems_of(error, data, Plan)) from None
    file = PlanFile(model, document, written)
    if problems := [*_of_seeds(model), *_of_values(model)]:
        raise file.refused(problems)
    return file


def _flattened(data: Mapping[str, Any]) -> tuple[dict[str, Any], dict[Key, Key]]:
    """Return the plan with dotted keys in its sections of values, and each value's key in the file."""
    flat, written = dict(data), dict[Key, Key]()

    def dotted(table: Mapping[str, Any], at: Key) -> dict[str, Any]:
        values = {}
        for key, value in _leaves(table, ()):
            name = str(key[0]) if len(key) == 1 else name_of(key)
            values[name] = value
            written[*at, name] = (*written.get(at[:1], at[:1]), *at[1:], *key)
        return values

    for section in ("set", "grid"):
        if isinstance(flat.get(section), dict):
            flat[section] = dotted(flat[section], (section,))
    if isinstance(flat.get("list"), list):
        flat["list"] = [
            dotted(entry, ("list", i)) if isinstance(entry, dict) else entry
            for i, entry in enumerate(flat["list"])
        ]
    for key, former in rename(flat, Plan):
        written[key] = (former,)
    sample = flat.get("sample")
    if isinstance(sample, dict) and isinstance(sample.get("ranges"), dict):
        ranges = dotted(sample["ranges"], RANGES)
        spans = {name: {"search": span} if isinstance(span, list) else span for name, span in ranges.items()}
        flat["sample"] = sample | {"ranges": spans}
    return flat, written


def _leaves(table: Mapping[str, Any], key: Key) -> Iterator[tuple[Key, Any]]:
    """Yield values with their keys; a quoted key that contains dots is a single key."""
    for part, value in table.items():
        whole = not key and "." in part
        if isinstance(value, dict) and value and not whole and "search" not in value:
            yield from _leaves(value, (*key, part))
        else:
            yield (*key, part), value


def _refused(document: Document, written: Mapping[Key, Key], problems: Iterable[Problem]) -> ConfigError:
    """Return the error for problems with a plan, each located at its key in the file."""
    moved = []
    for problem in problems:
        known = next((n for n in range(len(problem.key), 0, -1) if problem.key[:n] in written), 0)
        key, rest = problem.key[:known], problem.key[known:]
        if key[:2] == RANGES and rest[:1] == ("search",):
            rest = ()
        moved.append(problem.moved(key=(*written[key], *rest)) if known else problem)
    return document.refused(moved)


def _of_seeds(plan: Plan) -> Iterator[Problem]:
    for kind in ("world", "training"):
        seeds = plan.seeds(kind)
        if len(set(seeds)) < len(seeds):
            twice = next(seed for seed in seeds if seeds.count(seed) > 1)
            yield Problem((f"{kind}_seeds",), f"has {twice} twice", allowed="each seed once")
    for i, name in enumerate(plan.treatments):
        if name in plan.treatments[:i]:
            yield Problem(("treatments", i), "is named twice", name, "each treatment once")


def _of_values(plan: Plan) -> Iterator[Problem]:
    """Yield problems with sections of values: empty sections, and keys that occur in two sections."""
    if plan.grid is not None and not plan.grid:
        yield Problem(("grid",), "is empty", allowed='values by key: "species.deer.count" = [20, 40]')
    if plan.list is not None and not plan.list:
        yield Problem(("list",), "is empty", allowed='tables of values: [[list]] "species.deer.count" = 20')
    if plan.sample is not None and not plan.sample.ranges:
        allowed = 'ranges by key: "species.deer.reproduction.rate" = [0.004, 0.02]'
        yield Problem(RANGES, "is empty", allowed=allowed)
    for name, values in (plan.grid or {}).items():
        if not values:
            yield Problem(("grid", name), "has no values", values, "a list of values")
        for i, value in enumerate(values):
            if any(value == one and type(value) is type(one) for one in values[:i]):
                yield Problem(("grid", name, i), "occurs twice", value, "each value once")
    for i, entry in enumerate(plan.list or ()):
        if missing := (plan.list or [{}])[0].keys() ^ entry.keys():
            fault = f"has different keys from the first: {', '.join(sorted(missing))}"
            yield Problem(("list", i), fault, entry, "the same keys in all [[list]] tables")
    sections: dict[Key, Iterable[str]] = {
        ("set",): plan.set,
        ("grid",): plan.grid or {},
        RANGES: plan.sample.ranges if plan.sample else {},
        ("list", 0): (plan.list or [{}])[0],
    }
    seen: dict[Key, str] = {}
    for section, names in sections.items():
        for name in names:
            key = key_of(name)
            if key in seen:
                yield Problem((*section, name), f"is in {seen[key]} too", allowed="each key once")
            seen[key] = f"[{section[0]}]"
            if name in ELSEWHERE:
                yield Problem((*section, name), "cannot be varied", allowed=ELSEWHERE[name])


ELSEWHERE = {"seed": "world_seeds = N, or a list of seeds", "ticks": "ticks = N, at the top of the plan"}


DIGITS = 4  # number of significant digits of drawn numbers


@dataclass(frozen=True)
class Entry:
    """One value, and its key in the plan."""

    value: Any
    place: Key


Point = dict[str, Entry]


def points_of(plan: Plan, base: WorldConfig) -> Iterator[Point]:
    """Yield every point of a plan: lists × samples × grid, with the last key of the grid varying fastest."""
    factors: list[Sequence[Point]] = []
    if plan.list:
        factors.append(
            [
                {name: Entry(value, ("list", i, name)) for name, value in entry.items()}
                for i, entry in enumerate(plan.list)
            ]
        )
    if plan.sample is not None:
        factors.append(_drawn(plan.sample, base))
    for name, values in (plan.grid or {}).items():
        factors.append([{name: Entry(value, ("grid", name, i))} for i, value in enumerate(values)])
    for parts in product(*factors):
        yield {name: entry for part in parts for name, entry in part.items()}


def problems_of_ranges(plan: Plan, base: WorldConfig) -> Iterator[Problem]:
    """Yield problems with the ranges of a plan."""
    drawn = plan.sample
    data = base.model_dump() if drawn is not None else {}
    if drawn is not None and drawn.design != "lhs":
        at = ("sample", "design")
        if find_spec("SALib") is None:
            allowed = 'the package SALib: pip install -e ".[sensitivity]"'
            yield Problem(at, "needs a package that is not installed", drawn.design, allowed)
        if plan.grid or plan.list:
            yield Problem(at, "cannot be combined with [grid] or [[list]]", drawn.design, "only ranges")
        if drawn.design == "sobol" and drawn.points.bit_count() != 1:
            yield Problem(("sample", "points"), "is not a power of 2", drawn.points, "64, 128, 256, …")
    for name, span in (drawn.ranges if drawn is not None else {}).items():
        place, (low, high) = (*RANGES, name), span.search
        _, value, wrong = real_key(data, key_of(name))
        if wrong is not None:
            yield wrong.moved(key=place, value=name)
        elif value is not None and (isinstance(value, bool) or not isinstance(value, int | float)):
            yield Problem(
                place,
                f"is a range, but the value of its key is not a number: {value!r}",
                span.search,
                "the key of a number",
            )
        elif not low < high:
            yield Problem(place, "is not a range", span.search, "[low, high] with low < high")
        elif span.scale == "log" and low <= 0:
            yield Problem(place, "is impossible on a log scale", span.search, "low > 0")


def _drawn(sample: Sample, base: WorldConfig) -> list[Point]:
    shares = sample.shares()
    data = base.model_dump()
    points: list[Point] = [{} for _ in shares]
    for column, (name, span) in zip(shares.T, sample.ranges.items(), strict=True):
        value = real_key(data, key_of(name))[1]
        whole = all(isinstance(x, int) for x in (value, *span.search))
        for point, share in zip(points, column, strict=True):
            point[name] = Entry(_number(span, float(share), whole), (*RANGES, name))
    return points


def _number(span: Range, share: float, whole: bool) -> float:
    """Return the number at a fraction of a range; all integers, including the ends, are equally likely."""
    low, high = span.search
    if whole and span.scale == "linear":
        return low + int(share * (high - low + 1))
    if span.scale == "log":
        drawn = float(np.exp(np.log(low) + share * (np.log(high) - np.log(low))))
    else:
        drawn = low + share * (high - low)
    return round(drawn) if whole else min(max(float(f"{drawn:.{DIGITS}g}"), low), high)
