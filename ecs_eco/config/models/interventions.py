"""Interventions: what somebody does to a world while it runs, as in fishing, forestry, or an experiment in the field."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import Field, PlainSerializer

from ecs_eco.engine.section import Count, Name, Point, Real, Section, Share, about, function_name, quantity

Tick = Annotated[int, Field(ge=0, le=10**12)]
Region = Annotated[list[Real], Field(min_length=3, max_length=4)]
Uids = Annotated[list[Annotated[int, Field(ge=1, lt=2**63)]], Field(min_length=1, max_length=100_000)]
Corner = Annotated[list[Real], Field(min_length=2, max_length=2)]
REGION = "a circle [x, y, radius] or a rectangle [x0, y0, x1, y1]"


def _plain(value: Any) -> Any:
    return function_name(value) if callable(value) else value


Changes = Annotated[
    dict[str, Any],
    Field(min_length=1),
    PlainSerializer(lambda values, info: {k: _plain(v) if info.mode == "json" else v for k, v in values.items()}),
]


class Intervention(Section):
    """What all interventions have: when. Each is carried out at the start of its tick, before anything else happens."""

    at: Tick = quantity("the tick", "ticks")
    every: Annotated[int, Field(ge=1, le=10**12)] | None = quantity("again after each so many; absent: once", "ticks", None)
    until: Tick | None = quantity("not after this tick; absent: to the end of the run", "ticks", None)

    def due(self, tick: int) -> bool:
        """Whether it is carried out in this tick."""
        if tick == self.at or self.every is None:
            return tick == self.at
        return tick > self.at and (tick - self.at) % self.every == 0 and (self.until is None or tick <= self.until)

    def next(self, tick: int) -> int | None:
        """The first tick from this one on in which it is carried out; None where there is none."""
        if tick <= self.at or self.every is None:
            return self.at if tick <= self.at else None
        at = tick + (self.at - tick) % self.every
        return at if self.until is None or at <= self.until else None

    def once(self, tick: int) -> dict[str, Any]:
        """What is carried out in this tick, as a file would say it; JSON can hold it."""
        said = {k: v for k, v in self.model_dump(mode="json").items() if v is not None and k not in ("every", "until")}
        return said | {"at": tick}


class Cull(Intervention):
    """Some die; a cause of death of its own says so."""

    kind: Literal["cull"]
    species: Name = about("a species or an object type")
    share: Share | None = quantity("share of those alive that die, rounded to whole organisms", "1", None)
    count: Count | None = quantity("how many die, or all where there are fewer; give one of share, count and uids", "1", None)
    uids: Uids | None = about("those that die, where they live; give one of share, count and uids", None)
    region: Region | None = quantity(f"of those in {REGION}; absent: of all", "m", None)
    which: Literal["random", "oldest", "youngest", "richest", "poorest"] = about(
        "who dies first; rich is who has much energy; equals by the lower uid", "random"
    )
    cause: Annotated[str, Field(min_length=1, max_length=60)] = about("cause of death", "culled")


class Add(Intervention):
    """Newcomers, as those at the start are; they come to life at the end of the tick."""

    kind: Literal["add"]
    species: Name = about("a species or an object type")
    count: Count = quantity("how many, as far as max_count leaves room", "1")
    region: Region | None = quantity(f"at random places in {REGION}; absent: anywhere", "m", None)
    at_place: Point | None = quantity("all at this place", "m", None)


class Fence(Intervention):
    """A line that walkers do not cross from then on; smells, looks and births do."""

    kind: Literal["fence"]
    line: Annotated[list[Corner], Field(min_length=2)] | None = quantity("the corners of the fence", "m", None)
    region: Region | None = quantity(f"the fence goes around {REGION}; give line or region", "m", None)
    remove: bool = about("whether the fence that stands there is taken away; without line and region all are", False)


class Set(Intervention):
    """Values of the world file are others from then on."""

    kind: Literal["set"]
    set: Changes = about('dotted key = value, as "species.deer.reproduction.rate" = 0.02')


class Switch(Intervention):
    """Something stops, or goes on."""

    kind: Literal["switch"]
    species: Name | None = about("the species; absent: all", None)
    reproduction: bool | None = about("whether newborn come", None)
    learning: bool | None = about("whether policies learn; who stops forgets what it has not yet learnt from", None)


AnyIntervention = Annotated[Cull | Add | Fence | Set | Switch, Field(discriminator="kind")]


def coming(planned: Sequence[Intervention], tick: int) -> list[Intervention]:
    """Return those of `planned` that are due in a tick or after it, each with the first such tick as its `at`."""
    found = ((what, what.next(tick)) for what in planned)
    return [what.model_copy(update={"at": at}) for what, at in found if at is not None]


def describe(what: Mapping[str, Any] | str) -> str:
    """One line on an intervention that was carried out."""
    if isinstance(what, str):
        return what
    where = f" in {_place(what['region'])}" if what.get("region") else ""
    kind, species = what.get("kind"), what.get("species")
    if kind == "cull":
        if what.get("uids"):
            much = " and ".join(f"#{uid}" for uid in what["uids"]) if len(what["uids"]) < 4 else f"{len(what['uids']):,} chosen"
        else:
            much = f"{100 * what['share']:g} % of" if "share" in what else f"{what['count']:,}"
        first = "" if what.get("which", "random") == "random" else f", the {what['which']} first"
        return f"cull {much} {species}{where}{first}" + (f" ({what['cause']})" if what.get("cause", "culled") != "culled" else "")
    if kind == "add":
        where = f" at {_place(what['at_place'])}" if what.get("at_place") else where
        return f"add {what['count']:,} {species}{where}"
    if kind == "fence":
        around = f" around {_place(what['region'])}" if what.get("region") else ""
        along = f" along {' '.join(_place(p) for p in what['line'])}" if what.get("line") else ""
        return ("remove fence" if what.get("remove") else "fence") + (around or along or "s")
    if kind == "set":
        return ", ".join(f"{key} = {value}" for key, value in what["set"].items())
    done = [f"{name} {'on' if what[name] else 'off'}" for name in ("reproduction", "learning") if what.get(name) is not None]
    return f"{' and '.join(done)} for {species or 'all'}"


def _place(numbers: Any) -> str:
    return "[" + ", ".join(f"{x:g}" for x in numbers) + "]"
