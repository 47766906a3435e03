"""Interventions during a run, and continuous human use of land and sea."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Annotated, Any, Literal

from pydantic import Field, PlainSerializer

from ecs_eco.config.models.search import Ticks
from ecs_eco.inputs.section import (
    ANEW,
    FREE,
    Change,
    Count,
    Name,
    NonNegative,
    Pair,
    Point,
    Positive,
    Real,
    Section,
    Share,
    about,
    function_name,
    quantity,
)

Tick = Annotated[int, Field(ge=0, le=10**12)]
Region = Annotated[list[Real], Field(min_length=3, max_length=4)]
REGION = "a circle [x, y, radius] or a rectangle [x0, y0, x1, y1]"


class Intervention(Section):
    """The timing of an intervention.

    Interventions run at the start of their tick, before anything else.
    """

    at: Tick = quantity("tick of the intervention, or of the first one if it repeats", "ticks")
    every: Ticks | None = quantity("interval between repetitions; default: no repetition", "ticks", None)
    until: Tick | None = quantity("last possible tick; default: the end of the run", "ticks", None)

    def due(self, tick: int) -> bool:
        """Return whether the intervention runs in this tick."""
        return self.next(tick) == tick

    def next(self, tick: int) -> int | None:
        """Return the first tick, from this one on, in which the intervention runs, or None."""
        if tick <= self.at or self.every is None:
            return self.at if tick <= self.at else None
        at = tick + (self.at - tick) % self.every
        return at if self.until is None or at <= self.until else None

    def once(self, tick: int) -> dict[str, Any]:
        """Return the single occurrence in this tick as a dict of JSON types, as in a world file."""
        data = self.model_dump(mode="json", exclude={"every", "until"}) | {"at": tick}
        return {key: value for key, value in data.items() if value is not None}


class Cull(Intervention):
    """Kills some organisms and records `cause` as their cause of death."""

    kind: Literal["cull"]
    species: Name = about("a species or an object type")
    share: Share | None = quantity(
        "proportion of living organisms that die, rounded to a whole number", "1", None
    )
    count: Count | None = quantity(
        "number of organisms that die, or all if there are fewer; give exactly one of share, count and uids",
        "1",
        None,
    )
    uids: (
        Annotated[list[Annotated[int, Field(ge=1, lt=2**63)]], Field(min_length=1, max_length=100_000)] | None
    ) = about("uids of the organisms that die, if alive; give exactly one of share, count and uids", None)
    region: Region | None = quantity(f"only organisms in {REGION}; default: everywhere", "m", None)
    which: Literal["random", "oldest", "youngest", "richest", "poorest", "largest", "smallest"] = about(
        "which organisms die first, by age, energy or mass; ties are broken at random", "random"
    )
    cause: Annotated[str, Field(min_length=1, max_length=60)] = about("cause of death", "culled")


class Add(Intervention):
    """Adds organisms with the initial state of founders; they come to life at the end of the tick."""

    kind: Literal["add"]
    species: Name = about("a species or an object type")
    count: Count = quantity(
        "number of organisms, limited to the slots of max_count that are free at the start of the tick", "1"
    )
    region: Region | None = quantity(f"at random positions in {REGION}; default: anywhere", "m", None)
    at_place: Point | None = quantity("the position shared by all of them", "m", None)


class Fence(Intervention):
    """A new fence: walkers cannot cross it, but smells, sight and births can."""

    kind: Literal["fence"]
    line: Annotated[list[Pair], Field(min_length=2)] | None = quantity("the corners of the fence", "m", None)
    region: Region | None = quantity(f"the fence surrounds {REGION}; give either line or region", "m", None)
    remove: bool = about(
        "whether to remove the existing fence there, or all fences if neither line nor region is given", False
    )


class Road(Intervention):
    """A new strip of ground that changes the speed of walkers and their cost of moving; where two roads
    cross, the more recent one applies."""

    kind: Literal["road"]
    line: Annotated[list[Pair], Field(min_length=2)] | None = quantity(
        "the vertices of its center line", "m", None
    )
    width: Positive = quantity(
        "width of the strip; it covers at least the ground cells on the line", "m", 1.0
    )
    pace: Positive = quantity("factor for the speed of animals on it", "1", 1.0)
    cost: NonNegative = quantity("factor for the cost of moving per second", "1", 1.0)
    remove: bool = about("whether to remove the existing road there, or all roads if no line is given", False)


class Dose(Intervention):
    """Adds a substance to a field or to bodies from outside the world, or removes it: manure on a meadow,
    poison in a lake, salt licks. The ledger of matter counts it as an external input."""

    kind: Literal["dose"]
    field: Name | None = about(
        "the field that gets the dose, spread evenly over the region; give either field or species", None
    )
    species: Name | None = about(
        "a species or object type, each of whose bodies in the region gets the dose", None
    )
    substance: Name | None = about("the substance, for a dose to bodies; a field has its own", None)
    amount: Real = quantity(
        "the dose; a negative dose removes that amount, or all there is; for a smell without a substance, in "
        "the smell's own unit",
        "mol",
    )
    region: Region | None = quantity(f"{REGION}, at all depths in a volume; default: everywhere", "m", None)


class Set(Intervention):
    """Changes values in the world file for the rest of the run."""

    kind: Literal["set"]
    set: Annotated[
        dict[str, Any],
        Field(min_length=1),
        PlainSerializer(
            lambda values, info: {
                k: function_name(v) if info.mode == "json" and callable(v) else v for k, v in values.items()
            }
        ),
    ] = about('dotted key = value, such as "species.deer.reproduction.rate" = 0.02')


class Switch(Intervention):
    """Stops or resumes reproduction or learning."""

    kind: Literal["switch"]
    species: Name | None = about("the species; default: all", None)
    reproduction: bool | None = about("whether organisms reproduce", None)
    learning: bool | None = about(
        "whether policies learn; a policy that stops learning discards experience that it has not yet used",
        None,
    )


AnyIntervention = Annotated[Cull | Add | Fence | Road | Dose | Set | Switch, Field(discriminator="kind")]


def coming(planned: Sequence[Intervention], tick: int) -> list[Intervention]:
    """Return the interventions due in a tick or later, each with its next tick as `at`."""
    dated = ((intervention, intervention.next(tick)) for intervention in planned)
    return [intervention.model_copy(update={"at": at}) for intervention, at in dated if at is not None]


def describe(done: Mapping[str, Any] | str) -> str:
    """Return a one-line description of a past intervention."""
    if isinstance(done, str):
        return done
    where = f" in {_place(done['region'])}" if done.get("region") else ""
    kind, species = done.get("kind"), done.get("species")
    if kind == "cull":
        cause = f" ({done['cause']})" if done.get("cause", "culled") != "culled" else ""
        first = "" if done.get("which", "random") == "random" else f", the {done['which']} first"
        return f"cull {_amount(done)} {species}{where}{first}{cause}"
    if kind == "add":
        where = f" at {_place(done['at_place'])}" if done.get("at_place") else where
        return f"add {done['count']:,} {species}{where}"
    if kind == "fence":
        around = f" around {_place(done['region'])}" if done.get("region") else ""
        along = f" along {' '.join(_place(p) for p in done['line'])}" if done.get("line") else ""
        return ("remove fence" if done.get("remove") else "fence") + (around or along or "s")
    if kind == "road":
        along = f" along {' '.join(_place(p) for p in done['line'])}" if done.get("line") else "s"
        return f"remove road{along}" if done.get("remove") else f"road{along}, pace {done.get('pace', 1):g}"
    if kind == "dose":
        what = f" of {done['substance']}" if done.get("substance") else ""
        whom = f"to each {species}" if species else f"into {done['field']}"
        return f"dose {done['amount']:g}{what} {whom}{where}"
    if kind == "set":
        return ", ".join(f"{key} = {value}" for key, value in done["set"].items())
    switches = {name: done.get(name) for name in ("reproduction", "learning")}
    turned = (f"{name} {'on' if on else 'off'}" for name, on in switches.items() if on is not None)
    return f"{' and '.join(turned)} for {species or 'all'}"


def _amount(cull: Mapping[str, Any]) -> str:
    """Return the number of culled organisms as text."""
    if uids := cull.get("uids"):
        return " and ".join(f"#{uid}" for uid in uids) if len(uids) < 4 else f"{len(uids):,} chosen"
    return f"{100 * cull['share']:g}% of" if "share" in cull else f"{cull['count']:,}"


def _place(numbers: Sequence[float]) -> str:
    return "[" + ", ".join(f"{x:g}" for x in numbers) + "]"


class Use(Section, change=FREE):
    """The region and timing of a continuous use. It runs at the start of each tick, after interventions."""

    species: Name = about("a species or an object type", change=ANEW)
    region: Region | None = quantity(f"in {REGION}; default: everywhere", "m", None)
    at: Tick = quantity("the first tick", "ticks", 0)
    until: Tick | None = quantity("the last tick; default: the end of the run", "ticks", None)
    period: Positive | None = quantity("length of a year, used by season and quota", "s", None)
    season: Annotated[list[Share], Field(min_length=2, max_length=2)] | None = about(
        "start and end as fractions of each year; default: all year", None
    )

    def active(self, tick: int, dt: float) -> bool:
        """Return whether the use applies in a tick; `dt` is the length of a tick [s]."""
        if tick < self.at or (self.until is not None and tick > self.until):
            return False
        if self.season is None or self.period is None:
            return True
        (first, last), share = map(exact, self.season), tick / exact(self.period / dt) % 1
        return first <= share < last if first < last else share >= first or share < last

    def year(self, tick: int, dt: float) -> int:
        """Return a tick's year, from 0; `dt` is the length of a tick [s]. Without `period`, it is always 0."""
        return 0 if self.period is None else tick // exact(self.period / dt)


@lru_cache(256)
def exact(value: float) -> Fraction:
    """Return a value as a ratio of integers, so that rounding does not shift the ticks of a year."""
    return Fraction(value).limit_denominator(10**6)


class Harvest(Use):
    """Removes organisms or objects at a given rate, up to a quota: fishing, felling, hunting, reaping."""

    kind: Annotated[Literal["harvest"], Change(ANEW)]
    rate: NonNegative = quantity("proportion removed per second (the mortality F of Baranov 1918)", "1/s")
    quota: Count | None = quantity(
        "maximum number removed per year, or in total without `period`; default: no limit", "1", None
    )
    least: NonNegative | None = quantity(
        "minimum radius of a removed body, such as the mesh size of a net; default: no minimum", "m", None
    )
    most: NonNegative | None = quantity("maximum radius of a removed body; default: no maximum", "m", None)
    cause: Annotated[str, Field(min_length=1, max_length=60)] = about("cause of death", "harvested")


class Plant(Use):
    """Adds organisms or objects at a given rate, with the initial state of founders: planting, sowing,
    stocking."""

    kind: Annotated[Literal["plant"], Change(ANEW)]
    rate: NonNegative = quantity(
        "number per second, limited to the slots of max_count that are free at the start of the tick: none, if "
        "births fill all slots in each tick",
        "1/s",
    )
    up_to: Count | None = quantity(
        "number in the region above which none are added; default: no limit", "1", None
    )


AnyUse = Annotated[Harvest | Plant, Field(discriminator="kind")]
