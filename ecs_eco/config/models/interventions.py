"""Interventions in a running world, and what people do with land and sea all the time."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Annotated, Any, Literal

from pydantic import Field, PlainSerializer

from ecs_eco.inputs.section import (
    ANEW,
    FREE,
    Change,
    Count,
    Name,
    NonNegative,
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
Corner = Annotated[list[Real], Field(min_length=2, max_length=2)]
REGION = "a circle [x, y, radius] or a rectangle [x0, y0, x1, y1]"


class Intervention(Section):
    """The time of an intervention.

    Each is carried out at the start of its tick, before anything else happens.
    """

    at: Tick = quantity("the tick", "ticks")
    every: Annotated[int, Field(ge=1, le=10**12)] | None = quantity(
        "interval of repetition; absent: once", "ticks", None
    )
    until: Tick | None = quantity("last tick of repetition; absent: to the end of the run", "ticks", None)

    def due(self, tick: int) -> bool:
        """Whether it is carried out in this tick."""
        return self.next(tick) == tick

    def next(self, tick: int) -> int | None:
        """The first tick from this one on in which it is carried out; None where there is none."""
        if tick <= self.at or self.every is None:
            return self.at if tick <= self.at else None
        at = tick + (self.at - tick) % self.every
        return at if self.until is None or at <= self.until else None

    def once(self, tick: int) -> dict[str, Any]:
        """The single intervention of this tick as a dict of JSON types, as in a world file."""
        data = self.model_dump(mode="json", exclude={"every", "until"}) | {"at": tick}
        return {key: value for key, value in data.items() if value is not None}


class Cull(Intervention):
    """Some organisms die, with a cause of death of its own."""

    kind: Literal["cull"]
    species: Name = about("a species or an object type")
    share: Share | None = quantity("share of those alive that die, rounded to whole organisms", "1", None)
    count: Count | None = quantity(
        "how many die, or all if there are fewer; give one of share, count and uids", "1", None
    )
    uids: (
        Annotated[list[Annotated[int, Field(ge=1, lt=2**63)]], Field(min_length=1, max_length=100_000)] | None
    ) = about("uids of those that die, if alive; give one of share, count and uids", None)
    region: Region | None = quantity(f"of those in {REGION}; absent: of all", "m", None)
    which: Literal["random", "oldest", "youngest", "richest", "poorest"] = about(
        "which die first; the richest have the most energy; ties are broken at random", "random"
    )
    cause: Annotated[str, Field(min_length=1, max_length=60)] = about("cause of death", "culled")


class Add(Intervention):
    """Newcomers in the state of the founders; they come to life at the end of the tick."""

    kind: Literal["add"]
    species: Name = about("a species or an object type")
    count: Count = quantity("how many, limited by max_count", "1")
    region: Region | None = quantity(f"at random places in {REGION}; absent: anywhere", "m", None)
    at_place: Point | None = quantity("all at this place", "m", None)


class Fence(Intervention):
    """A line that walkers cannot cross from then on; smells, sight and births can."""

    kind: Literal["fence"]
    line: Annotated[list[Corner], Field(min_length=2)] | None = quantity(
        "the corners of the fence", "m", None
    )
    region: Region | None = quantity(f"the fence goes around {REGION}; give line or region", "m", None)
    remove: bool = about(
        "whether to remove the fence that stands there; without line and region, all fences", False
    )


class Road(Intervention):
    """A strip of ground on which walkers are faster or slower from then on, and pay more or less for each
    second; where two cross, the later one counts."""

    kind: Literal["road"]
    line: Annotated[list[Corner], Field(min_length=2)] | None = quantity(
        "the corners of its middle line", "m", None
    )
    width: Positive = quantity(
        "breadth of the strip; at least the cells of the ground that the line passes", "m", 1.0
    )
    pace: Positive = quantity("factor of the speed of animals on it", "1", 1.0)
    cost: NonNegative = quantity("factor of the cost of moving per second", "1", 1.0)
    remove: bool = about("whether to take away the road that lies there; without line, all roads", False)


class Dose(Intervention):
    """A substance comes into the world from outside, into a field or into bodies, or is taken away: manure on
    a meadow, poison in a lake, salt licks. The ledger of matter counts it as brought in."""

    kind: Literal["dose"]
    field: Name | None = about(
        "a field: the dose is spread evenly over its cells in the region; give field or species", None
    )
    species: Name | None = about(
        "a species or an object type: each of its bodies in the region gets the dose", None
    )
    substance: Name | None = about("what the bodies get; a field has its own", None)
    amount: Real = quantity(
        "the dose; below 0: so much is taken away, or all that is there; of a smell "
        "without substance in its own unit",
        "mol",
    )
    region: Region | None = quantity(f"{REGION}, in a volume at all depths; absent: everywhere", "m", None)


class Set(Intervention):
    """Values of the world file change from then on."""

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
    """Reproduction or learning stops, or resumes."""

    kind: Literal["switch"]
    species: Name | None = about("the species; absent: all", None)
    reproduction: bool | None = about("whether newborn come", None)
    learning: bool | None = about(
        "whether policies learn; one that stops discards the experience it has not yet learned from", None
    )


AnyIntervention = Annotated[Cull | Add | Fence | Road | Dose | Set | Switch, Field(discriminator="kind")]


def coming(planned: Sequence[Intervention], tick: int) -> list[Intervention]:
    """Return those of `planned` that are due in a tick or after it,
    each with the first such tick as its `at`."""
    dated = ((intervention, intervention.next(tick)) for intervention in planned)
    return [intervention.model_copy(update={"at": at}) for intervention, at in dated if at is not None]


def describe(done: Mapping[str, Any] | str) -> str:
    """One line on an intervention that was carried out."""
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
    """How many a cull took, in words."""
    if uids := cull.get("uids"):
        return " and ".join(f"#{uid}" for uid in uids) if len(uids) < 4 else f"{len(uids):,} chosen"
    return f"{100 * cull['share']:g} % of" if "share" in cull else f"{cull['count']:,}"


def _place(numbers: Sequence[float]) -> str:
    return "[" + ", ".join(f"{x:g}" for x in numbers) + "]"


class Use(Section, change=FREE):
    """Where and when something is done, at the start of a tick, after interventions."""

    species: Name = about("a species or an object type", change=ANEW)
    region: Region | None = quantity(f"in {REGION}; absent: everywhere", "m", None)
    at: Tick = quantity("the first tick", "ticks", 0)
    until: Tick | None = quantity("the last tick; absent: to the end of the run", "ticks", None)
    period: Positive | None = quantity("length of a year, for season and quota", "s", None)
    season: Annotated[list[Share], Field(min_length=2, max_length=2)] | None = about(
        "from which share of each year to which; absent: all the year", None
    )

    def active(self, tick: int, dt: float) -> bool:
        """Whether it is done in a tick of dt [s]."""
        if tick < self.at or (self.until is not None and tick > self.until):
            return False
        if self.season is None or self.period is None:
            return True
        (first, last), share = map(exact, self.season), tick / exact(self.period / dt) % 1
        return first <= share < last if first < last else share >= first or share < last

    def year(self, tick: int, dt: float) -> int:
        """The number of the year that a tick of dt [s] is in, from 0; always 0 without years."""
        return 0 if self.period is None else tick // exact(self.period / dt)


@lru_cache(256)
def exact(value: float) -> Fraction:
    """The ratio of whole numbers that a value stands for, 1/5 for 0.2: with it every year has the same ticks,
    which the rounding of floats would shift."""
    return Fraction(value).limit_denominator(10**6)


class Harvest(Use):
    """Organisms or objects are taken at a rate, up to a quota: fishing, felling, hunting, reaping."""

    kind: Annotated[Literal["harvest"], Change(ANEW)]
    rate: NonNegative = quantity(
        "share of those there that is taken in a second (the mortality F of Baranov 1918)", "1/s"
    )
    quota: Count | None = quantity(
        "most that is taken in a year, or ever where there are no years; absent: no limit", "1", None
    )
    least: NonNegative | None = quantity(
        "least radius of a body that is taken, as of a mesh; absent: any", "m", None
    )
    most: NonNegative | None = quantity("greatest radius of a body that is taken; absent: any", "m", None)
    cause: Annotated[str, Field(min_length=1, max_length=60)] = about("cause of death", "harvested")


class Plant(Use):
    """Newcomers are brought at a rate, in the state of founders: planting, sowing, stocking."""

    kind: Annotated[Literal["plant"], Change(ANEW)]
    rate: NonNegative = quantity("how many per second", "1/s")
    up_to: Count | None = quantity("number there beyond which none are brought; absent: no limit", "1", None)


AnyUse = Annotated[Harvest | Plant, Field(discriminator="kind")]
