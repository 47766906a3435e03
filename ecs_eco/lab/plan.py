"""plan.toml: a world, the values to vary, seeds and treatments, as it is written and before worlds are made."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationError

from ecs_eco.config import WorldConfig
from ecs_eco.config.document import Document
from ecs_eco.config.explain import problems_of
from ecs_eco.config.models.search import Range, Ticks
from ecs_eco.config.ranges import Key, key_of, name_of, real_key
from ecs_eco.config.reading import read_toml
from ecs_eco.engine.errors import ConfigError, Problem
from ecs_eco.inputs.section import Section, about, quantity

Seed = Annotated[int, Field(ge=0, lt=2**63)]
Seeds = Annotated[
    Annotated[int, Field(ge=1, le=100_000), Tag("number")]
    | Annotated[list[Seed], Field(min_length=1, max_length=100_000), Tag("names")],
    Discriminator(lambda value: "names" if isinstance(value, list) else "number"),
]
Names = list[str]
Values = list[Any]
Points = list[dict[str, Any]]
MOST_JOBS = 100_000


class Hypercube(Section):
    """Points that are spread evenly over ranges of numbers, however many numbers there are."""

    points: int = quantity("points", "1", ge=1, le=MOST_JOBS)
    seed: Seed = about("seed of the points", 0)
    ranges: dict[str, Range] = about("[low, high] of each number, by its dotted key")


class Plan(Section):
    """The whole plan file; the values of grid, latin_hypercube and list are all crossed."""

    world: str = about("a world file, relative to the plan, or the name of a shipped world")
    title: str = about("a title for the report", "")
    ticks: Ticks | None = quantity("length of a run; absent: the world's own", "ticks", None)
    world_seeds: Seeds = about("number of world seeds, from 1, or a list of them", 1)
    training_seeds: Seeds | None = about(
        "number of training seeds, from 1, or a list of them; absent: nothing is trained", None
    )
    retrain: bool = about(
        "whether policies are trained anew under each set of values and each treatment "
        "that changes values; else in the world as it is",
        False,
    )
    policies: str = about(
        "policies that runs begin with, where nothing is trained: trained, random, "
        "untrained, or a folder, relative to the plan",
        "trained",
    )
    treatments: Names = about(
        "treatments beside the world as it is, as `ecs-eco compare --treatment` takes them", []
    )
    reporters: dict[str, Any] = about(
        "what to measure besides the world's own reporters, as in a world file", {}
    )
    set: dict[str, Any] = about("values for all runs, by dotted key", {})
    grid: dict[str, Values] | None = about("the values of each key; all are combined", None)
    latin_hypercube: Hypercube | None = about("numbers that are drawn from ranges", None)
    list: Points | None = about("sets of values that belong together", None)
    checkpoint_every: Ticks | None = quantity(
        "ticks between the checkpoints of a run; absent: 20 in a run, at least 2,000 apart", "ticks", None
    )

    def seeds(self, kind: str) -> Sequence[int]:
        """Return the "world" or "training" seeds."""
        given = self.training_seeds if kind == "training" else self.world_seeds
        return tuple(range(1, given + 1)) if isinstance(given, int) else tuple(given or ())


@dataclass(frozen=True)
class PlanFile:
    """A plan that was read, and where each of its values stands."""

    plan: Plan
    document: Document
    places: Mapping[tuple[str, str], Key]  # section of values and dotted key → key in the file

    @property
    def folder(self) -> Path:
        """Folder of the plan, the base of relative file names."""
        return self.document.folder

    def place(self, section: str, name: str) -> Key:
        """Return the key in the file at which a value of a section stands."""
        return self.places.get((section, name), (*section.split("/"), name))


def read_plan(plan: str | Path | Mapping[str, Any]) -> PlanFile:
    """Read a plan, a file or a dict, whose relative paths are those of the working folder.

    Raises ConfigError for a plan that is no valid TOML, or has unknown keys or values of a wrong type.
    """
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
    data, places = _flattened(document.data)
    try:
        model = Plan.model_validate(data)
    except ValidationError as error:
        moved = [_in_file(p, places) for p in problems_of(error, data, Plan)]
        raise document.refused(moved) from None
    file = PlanFile(model, document, places)
    if problems := [*_of_seeds(model), *_of_values(file)]:
        raise document.refused(problems)
    return file


def _flattened(data: Mapping[str, Any]) -> tuple[dict[str, Any], dict[tuple[str, str], Key]]:
    """Return the plan with dotted keys in its sections of values, however TOML nests them, and their places."""
    flat: dict[str, Any] = dict(data)
    places: dict[tuple[str, str], Key] = {}
    for section in ("set", "grid"):
        if isinstance(data.get(section), dict):
            flat[section] = _dotted(data[section], section, (section,), places)
    cube = data.get("latin_hypercube")
    if isinstance(cube, dict) and isinstance(cube.get("ranges"), dict):
        section = "latin_hypercube/ranges"
        ranges = _dotted(cube["ranges"], section, ("latin_hypercube", "ranges"), places)
        flat["latin_hypercube"] = cube | {
            "ranges": {
                name: {"search": span} if isinstance(span, list) else span for name, span in ranges.items()
            }
        }
    if isinstance(data.get("list"), list):
        flat["list"] = [
            _dotted(entry, f"list/{i}", ("list", i), places) if isinstance(entry, dict) else entry
            for i, entry in enumerate(data["list"])
        ]
    return flat, places


def _dotted(
    table: Mapping[str, Any], section: str, at: Key, places: dict[tuple[str, str], Key]
) -> dict[str, Any]:
    """Return the values of a table by dotted key; a key in quotes that has dots is one already."""
    flat: dict[str, Any] = {}
    for key, value in _leaves(table, ()):
        name = str(key[0]) if len(key) == 1 else name_of(key)
        flat[name] = value
        places[section, name] = (*at, *key)
    return flat


def _leaves(table: Mapping[str, Any], key: Key) -> Iterator[tuple[Key, Any]]:
    for part, value in table.items():
        whole = not key and "." in part
        if isinstance(value, dict) and value and not whole and "search" not in value:
            yield from _leaves(value, (*key, part))
        else:
            yield (*key, part), value


def _in_file(problem: Problem, places: Mapping[tuple[str, str], Key]) -> Problem:
    """The problem at the place where the file has what is flat here."""
    key = problem.key
    for end, section in ((1, "set"), (1, "grid"), (2, "latin_hypercube/ranges")):
        if "/".join(map(str, key[:end])) == section and len(key) > end:
            rest = key[end + 1 :]
            if section == "latin_hypercube/ranges" and rest[:1] == ("search",):
                rest = ()
            return problem.moved(key=(*places.get((section, str(key[end])), key[: end + 1]), *rest))
    return problem


def _of_seeds(plan: Plan) -> Iterator[Problem]:
    for kind in ("world", "training"):
        seeds = plan.seeds(kind)
        if len(set(seeds)) < len(seeds):
            twice = next(seed for seed in seeds if seeds.count(seed) > 1)
            yield Problem((f"{kind}_seeds",), f"has {twice} twice", allowed="each seed once")
    for i, name in enumerate(plan.treatments):
        if name in plan.treatments[:i]:
            yield Problem(("treatments", i), "is named twice", name, "each treatment once")


def _of_values(file: PlanFile) -> Iterator[Problem]:
    """Yield the problems of sections of values: empty ones, and keys that are in two of them."""
    plan = file.plan
    if plan.grid is not None and not plan.grid:
        yield Problem(("grid",), "is empty", allowed='values by key: "species.deer.count" = [20, 40]')
    if plan.list is not None and not plan.list:
        yield Problem(("list",), "is empty", allowed='tables of values: [[list]] "species.deer.count" = 20')
    if plan.latin_hypercube is not None and not plan.latin_hypercube.ranges:
        yield Problem(
            ("latin_hypercube", "ranges"),
            "is empty",
            allowed='ranges by key: "species.deer.reproduction.rate" = [0.004, 0.02]',
        )
    for name, values in (plan.grid or {}).items():
        if not values:
            yield Problem(file.place("grid", name), "has no values", values, "a list of values")
        for i, value in enumerate(values):
            if any(value == one and type(value) is type(one) for one in values[:i]):
                yield Problem((*file.place("grid", name), i), "is there twice", value, "each value once")
    for i, entry in enumerate(plan.list or ()):
        if missing := (plan.list or [{}])[0].keys() ^ entry.keys():
            yield Problem(
                ("list", i),
                f"differs in keys from the first: {', '.join(sorted(missing))}",
                entry,
                "the same keys in all tables of [[list]]",
            )
    yield from _twice(file)


def _twice(file: PlanFile) -> Iterator[Problem]:
    plan = file.plan
    sections = {
        "set": plan.set,
        "grid": plan.grid or {},
        "latin_hypercube/ranges": plan.latin_hypercube.ranges if plan.latin_hypercube else {},
        "list/0": (plan.list or [{}])[0],
    }
    seen: dict[Key, str] = {}
    for section, names in sections.items():
        for name in names:
            key = key_of(name)
            if key in seen:
                yield Problem(file.place(section, name), f"is in {seen[key]} too", allowed="each key once")
            seen[key] = f"[{section.partition('/')[0]}]"
            if name in ELSEWHERE:
                yield Problem(file.place(section, name), "cannot be varied", allowed=ELSEWHERE[name])


ELSEWHERE = {"seed": "world_seeds = N, or a list of seeds", "ticks": "ticks = N, at the top of the plan"}


DIGITS = 4  # significant ones, of drawn numbers


@dataclass(frozen=True)
class Entry:
    """One value, and where it stands in the plan."""

    value: Any
    place: Key


Point = dict[str, Entry]


def points_of(file: PlanFile, base: WorldConfig) -> Iterator[Point]:
    """Yield every point of a plan: lists, hypercube and grid crossed, the last key of the grid fastest."""
    plan = file.plan
    factors: list[Sequence[Point]] = []
    if plan.list:
        factors.append(
            [
                {name: Entry(value, file.place(f"list/{i}", name)) for name, value in entry.items()}
                for i, entry in enumerate(plan.list)
            ]
        )
    if plan.latin_hypercube is not None:
        factors.append(_drawn(file, plan.latin_hypercube, base))
    for name, values in (plan.grid or {}).items():
        place = file.place("grid", name)
        factors.append([{name: Entry(value, (*place, i))} for i, value in enumerate(values)])
    for parts in product(*factors):
        yield {name: entry for part in parts for name, entry in part.items()}


def number_of_points(file: PlanFile) -> int:
    """Return how many points a plan has."""
    plan = file.plan
    n = len(plan.list or [()]) * (plan.latin_hypercube.points if plan.latin_hypercube else 1)
    for values in (plan.grid or {}).values():
        n *= len(values)
    return n


def problems_of_ranges(file: PlanFile, base: WorldConfig) -> Iterator[Problem]:
    """Yield what is wrong with the ranges of a plan's hypercube."""
    cube = file.plan.latin_hypercube
    data = base.model_dump() if cube is not None else {}
    for name, span in (cube.ranges if cube is not None else {}).items():
        place, (low, high) = file.place("latin_hypercube/ranges", name), span.search
        _, value, wrong = real_key(data, key_of(name))
        if wrong is not None:
            yield wrong.moved(key=place, value=name)
        elif value is not None and (isinstance(value, bool) or not isinstance(value, int | float)):
            yield Problem(
                place,
                f"is a range, and its key holds no number: {value!r}",
                span.search,
                "the key of a number",
            )
        elif not low < high:
            yield Problem(place, "is no range", span.search, "[low, high] with low < high")
        elif span.scale == "log" and low <= 0:
            yield Problem(place, "cannot be taken on a log scale", span.search, "low > 0")


def _drawn(file: PlanFile, cube: Hypercube, base: WorldConfig) -> list[Point]:
    """Return the points of a Latin hypercube (McKay, Beckman and Conover 1979), in the order of drawing."""
    from scipy.stats import qmc

    shares = qmc.LatinHypercube(len(cube.ranges), rng=cube.seed).random(cube.points)
    data = base.model_dump()
    points: list[Point] = [{} for _ in range(cube.points)]
    for column, (name, span) in zip(shares.T, cube.ranges.items(), strict=True):
        value = real_key(data, key_of(name))[1]
        whole = all(isinstance(x, int) for x in (value, *span.search))
        place = file.place("latin_hypercube/ranges", name)
        for point, share in zip(points, column, strict=True):
            point[name] = Entry(_number(span, float(share), whole), place)
    return points


def _number(span: Range, share: float, whole: bool) -> float:
    """Return the number at a share of a range; whole ones have equal chances, ends included."""
    low, high = span.search
    if whole and span.scale == "linear":
        return low + int(share * (high - low + 1))
    if span.scale == "log":
        drawn = float(np.exp(np.log(low) + share * (np.log(high) - np.log(low))))
    else:
        drawn = low + share * (high - low)
    return round(drawn) if whole else min(max(float(f"{drawn:.{DIGITS}g}"), low), high)
