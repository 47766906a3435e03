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
    """The time of an intervention.

    Each is carried out at the start of its tick, before anything else.
    """

    at: Tick = quantity("the tick", "ticks")
    every: Ticks | None = quantity("interval of repetition; absent: once", "ticks", None)
    until: Tick | None = quantity("last tick of repetition; absent: to the end of the run", "ticks", None)

    def due(self, tick: int) -> bool:
        """Return whether it is carried out in this tick."""
        return self.next(tick) == tick

    def next(self, tick: int) -> int | None:
        """Return the first tick from this tick on in which it is carried out, or None."""
        if tick <= self.at or self.every is None:
            return self.at if tick <= self.at else None
        at = tick + (self.at - tick) % self.every
        return at if self.until is None or at <= self.until else None

    def once(self, tick: int) -> dict[str, Any]:
        """Return this tick's single intervention as a dict of JSON types, as in a world file."""
        data = self.model_dump(mode="json", exclude={"every", "until"}) | {"at": tick}
        return {key: value for key, value in data.items() if value is not None}


class Cull(Intervention):
    """Kills some organisms, with its own cause of death."""

    kind: Literal["cull"]
    species: Name = about("a species or an object type")
    share: Share | None = quantity(
        "proportion of the living organisms that die, rounded to whole organisms", "1", None
    )
    count: Count | None = quantity(
        "number of organisms that die, or all if there are fewer; give one of share, count and uids",
        "1",
        None,
    )
    uids: (
        Annotated[list[Annotated[int, Field(ge=1, lt=2**63)]], Field(min_length=1, max_length=100_000)] | None
    ) = about("uids of the organisms that die, if alive; give one of share, count and uids", None)
    region: Region | None = quantity(f"only organisms in {REGION}; absent: all", "m", None)
    which: Literal["random", "oldest", "youngest", "richest", "poorest"] = about(
        "which organisms die first; the richest have the most energy; ties are broken at random", "random"
    )
    cause: Annotated[str, Field(min_length=1, max_length=60)] = about("cause of death", "culled")


class Add(Intervention):
    """Adds organisms in the state of founders; they come to life at the end of the tick."""

    kind: Literal["add"]
    species: Name = about("a species or an object type")
    count: Count = quantity("number of organisms, limited by max_count", "1")
    region: Region | None = quantity(f"at random positions in {REGION}; absent: anywhere", "m", None)
    at_place: Point | None = quantity("all at this position", "m", None)


class Fence(Intervention):
    """A new line that walkers cannot cross; smells, sight and births can."""

    kind: Literal["fence"]
    line: Annotated[list[Pair], Field(min_length=2)] | None = quantity("the corners of the fence", "m", None)
    region: Region | None = quantity(f"the fence surrounds {REGION}; give line or region", "m", None)
    remove: bool = about(
        "whether to remove the existing fence there; without line and region, all fences", False
    )


class Road(Intervention):
    """A new strip of ground on which walkers are faster or slower and pay more or less per second; where
    two roads cross, the later road applies."""

    kind: Literal["road"]
    line: Annotated[list[Pair], Field(min_length=2)] | None = quantity(
        "the vertices of its center line", "m", None
    )
    width: Positive = quantity(
        "width of the strip; it covers at least the ground cells on the line", "m", 1.0
    )
    pace: Positive = quantity("factor for the speed of animals on it", "1", 1.0)
    cost: NonNegative = quantity("factor for the cost of moving per second", "1", 1.0)
    remove: bool = about("whether to remove the existing road there; without line, all roads", False)


class Dose(Intervention):
    """A substance enters the world from outside, into a field or into bodies, or is removed: manure on a
    meadow, poison in a lake, salt licks. The ledger of matter counts it as an external input."""

    kind: Literal["dose"]
    field: Name | None = about(
        "a field: the dose is spread evenly over its cells in the region; give either field or species", None
    )
    species: Name | None = about(
        "a species or an object type: each of its bodies in the region gets the dose", None
    )
    substance: Name | None = about("the substance added to bodies; a field has its own", None)
    amount: Real = quantity(
        "the dose; below 0: this amount is removed, or all if there is less; for a smell without substance "
        "in the unit of the smell",
        "mol",
    )
    region: Region | None = quantity(f"{REGION}, in a volume at all depths; absent: everywhere", "m", None)


class Set(Intervention):
    """Changes values of the world file for the rest of the run."""

    kind: Literal["set"]
    set: Annotated[
        dict[str, Any],
        Field(min_length=1),
        PlainSerializer(
            lambda values, info: {
                k: function_name(v) if info.mode == "json" and callable(v) else v for k, v in values.items()
            }
        ),
    ] = about('dotted key = value, as "species.deer.reproduction.rate" = 0.02')


class Switch(Intervention):
    """Reproduction or learning stops or resumes."""

    kind: Literal["switch"]
    species: Name | None = about("the species; absent: all", None)
    reproduction: bool | None = about("whether organisms reproduce", None)
    learning: bool | None = about(
        "whether policies learn; a policy that stops discards the experience that it has not yet learned from",
        None,
    )


AnyIntervention = Annotated[Cull | Add | Fence | Road | Dose | Set | Switch, Field(discriminator="kind")]


def coming(planned: Sequence[Intervention], tick: int) -> list[Intervention]:
    """Return the interventions due from a tick on, each with its first such tick as `at`."""
    dated = ((intervention, intervention.next(tick)) for intervention in planned)
    return [intervention.model_copy(update={"at": at}) for intervention, at in dated if at is not None]


def describe(done: Mapping[str, Any] | str) -> str:
    """Return one line that describes an intervention that was carried out."""
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
    """Return the number of organisms in a cull, in words."""
    if uids := cull.get("uids"):
        return " and ".join(f"#{uid}" for uid in uids) if len(uids) < 4 else f"{len(uids):,} chosen"
    return f"{100 * cull['share']:g} % of" if "share" in cull else f"{cull['count']:,}"


def _place(numbers: Sequence[float]) -> str:
    return "[" + ", ".join(f"{x:g}" for x in numbers) + "]"


class Use(Section, change=FREE):
    """Place and time of a continuous use, at the start of a tick, after interventions."""

    species: Name = about("a species or an object type", change=ANEW)
    region: Region | None = quantity(f"in {REGION}; absent: everywhere", "m", None)
    at: Tick = quantity("the first tick", "ticks", 0)
    until: Tick | None = quantity("the last tick; absent: to the end of the run", "ticks", None)
    period: Positive | None = quantity("length of a year, for season and quota", "s", None)
    season: Annotated[list[Share], Field(min_length=2, max_length=2)] | None = about(
        "start and end as fractions of each year; absent: all year", None
    )

    def active(self, tick: int, dt: float) -> bool:
        """Return whether the use takes place in a tick of dt [s]."""
        if tick < self.at or (self.until is not None and tick > self.until):
            return False
        if self.season is None or self.period is None:
            return True
        (first, last), share = map(exact, self.season), tick / exact(self.period / dt) % 1
        return first <= share < last if first < last else share >= first or share < last

    def year(self, tick: int, dt: float) -> int:
        """Return the number of the year that contains a tick of dt [s], from 0; always 0 without years."""
        return 0 if self.period is None else tick // exact(self.period / dt)


@lru_cache(256)
def exact(value: float) -> Fraction:
    """Return the ratio of integers for a value, so that rounding does not shift the ticks of a year."""
    return Fraction(value).limit_denominator(10**6)


class Harvest(Use):
    """Removes organisms or objects at a rate, up to a quota: fishing, felling, hunting, reaping."""

    kind: Annotated[Literal["harvest"], Change(ANEW)]
    rate: NonNegative = quantity("proportion removed per second (the mortality F of Baranov 1918)", "1/s")
    quota: Count | None = quantity(
        "maximum number removed per year, or in total without years; absent: no limit", "1", None
    )
    least: NonNegative | None = quantity(
        "minimum radius of a removed body, as set by a mesh; absent: any", "m", None
    )
    most: NonNegative | None = quantity("maximum radius of a removed body; absent: any", "m", None)
    cause: Annotated[str, Field(min_length=1, max_length=60)] = about("cause of death", "harvested")


class Plant(Use):
    """Adds organisms or objects at a rate, in the state of founders: planting, sowing, stocking."""

    kind: Annotated[Literal["plant"], Change(ANEW)]
    rate: NonNegative = quantity("number per second", "1/s")
    up_to: Count | None = quantity(
        "number in the region above which none are added; absent: no limit", "1", None
    )


AnyUse = Annotated[Harvest | Plant, Field(discriminator="kind")]
