"""The width of the ghost zone beyond a band's edges, and features that rule out division."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from ecs_eco.bands.fields import halo_of
from ecs_eco.components import Body, Growth, Position, Shape
from ecs_eco.config.features.feature import of_each
from ecs_eco.engine.errors import ConfigError, Problem
from ecs_eco.genomes.choices import CHOICES
from ecs_eco.learning.learner import RolloutLearner

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

INSTEAD = "--bands without --divided, so that each process holds the whole state"
SENSES = ("own", "nearest", "touch", "smell", "rays", "property", "light", "temperature", "pressure")


class Widths(NamedTuple):
    """Distances that ghosts and field rows extend beyond the edges."""

    sensing: float  # [m] ghosts before sensing: longest sensing range, or flow into this band's fields
    acting: float  # [m] ghosts after moving: all organisms that may affect this band's organisms in this tick
    halos: list[int]  # number of rows beyond the edges, for each field
    properties: bool  # whether any sensor reads more than positions and bodies

    def rows(self, world: SpatialWorld) -> tuple[int, int]:
        """Return both ghost widths in rows of cells."""
        sensing, acting = (
            math.ceil(width * world.space.shape[1] / world.space.size[1] - 1e-6)
            for width in (self.sensing, self.acting)
        )
        return max(sensing, 1), max(acting, 1)


def widths_of(world: SpatialWorld) -> Widths:
    """Return how far beyond its edges a band needs data."""
    living = [t for t in world.tables.values() if Body in t]
    largest = max((largest_of(t) for t in living), default=0.0)
    noses = max((nose_of(t) for t in living), default=0.0)
    sensed = max((reach + largest for t in living for reach in _reaches(t)), default=0.0)
    touched = max((2 * largest + reach for t in living for reach in _touches(t)), default=0.0)
    halos = [halo_of(field, world.dt, noses) for field in world.fields.values()]
    flows = max(
        ((field._plan(world.dt)[0] + 1) / float(field.inverse[1]) for field in world.fields.values()),
        default=0.0,
    )
    acting = meals_of(world, living)
    acting += sum(2 * largest_of(t) + way.reach for t, way in _ways(living) if way.kind == "sexual")
    acting += max(
        (
            max(way.spacing, 2 * largest)
            for _, way in _ways(living)
            if way.kind in ("sexual", "asexual", "simplified")
        ),
        default=0.0,
    )
    properties = any(sensor.kind == "property" for t in living for sensor in _sensors(t))
    return Widths(max(sensed, touched, flows), acting, halos, properties)


def meals_of(world: SpatialWorld, living: list[Table]) -> float:
    """Return the distance [m] within which ghosts can affect whether a body eats or is eaten: one reach per
    eater in its food chain and one for closer items, at least three; two more if an eater can win several."""
    reach = max(
        (
            largest_of(t) + largest_of(world.tables[food.eats]) + food.reach
            for t in living
            for food in t.species.diet
        ),
        default=0.0,
    )
    return reach * max(3, eaters_in_line(living) + (3 if any(len(t.species.diet) > 1 for t in living) else 1))


def eaters_in_line(tables: Iterable[Table]) -> int:
    """Return the number of eaters in the longest food chain; more than there are tables if it is a circle."""
    eaten = {t.name: {food.eats for food in t.species.diet} for t in tables}
    eaters, n = {name for name, foods in eaten.items() if foods}, 0
    while eaters and n <= len(eaten):
        eaters, n = {name for eater in eaters for name in eaten[eater] if eaten.get(name)}, n + 1
    return n


def largest_of(table: Table) -> float:
    """Return the largest radius [m] of a table's present and future bodies."""
    radius = table[Body].radius[table.rows()]
    return max(float(table.species.radius or 0.0), float(radius.max(initial=0.0)))


def nose_of(table: Table) -> float:
    """Return the largest distance [m] of a nose from the center of its body."""
    return largest_of(table) * max(
        (math.hypot(*sensor.at[:2]) for sensor in _sensors(table) if sensor.kind == "smell"), default=0.0
    )


def _sensors(table: Table) -> list[Any]:
    return list(table.species.sensors)


def _reaches(table: Table) -> Iterator[float]:
    for sensor in _sensors(table):
        if (radius := getattr(sensor, "range", None)) is not None:
            at = getattr(sensor, "at", None) or [0.0]
            yield float(radius) + largest_of(table) * math.hypot(*at[:2])


def _touches(table: Table) -> Iterator[float]:
    return (float(getattr(sensor, "reach", 0.0)) for sensor in _sensors(table) if sensor.kind == "touch")


def _ways(tables: list[Table]) -> Iterator[tuple[Table, Any]]:
    return ((t, t.species.reproduction) for t in tables if t.species.reproduction is not None)


# --- features that cannot be divided ------------------------------------------------------------------------


def require_divisible(world: SpatialWorld, size: int) -> Widths:
    """Return the ghost widths. Raise a ConfigError that lists every reason why the world cannot be divided
    among this many processes."""
    problems = [
        Problem(key, f"the state of {what} cannot be divided between processes", allowed=INSTEAD)
        for key, what in (*_of_world(world), *_of_tables(world))
    ]
    if problems:
        raise ConfigError(problems)
    widths = widths_of(world)
    require_height(world, size, least_height(world, widths), widths)
    return widths


def _of_world(world: SpatialWorld) -> Iterator[tuple[tuple[Any, ...], str]]:
    if world.config is None:
        yield (), "a world built in Python"
        return
    if world.space.volume:
        yield ("space", "size"), "a volume"
    for key in ("terrain", "water", "sun", "land"):
        if getattr(world.config, key, None) is not None:
            yield (key,), f"a world with {key}"
    if eaters_in_line(world.tables.values()) > len(world.tables):
        yield ("species",), "a world in which a species can eat itself, or species can eat each other,"
    if world.config.interventions:
        yield ("interventions",), "a world with interventions"
    if world.config.archipelago is not None:
        yield ("archipelago",), "an island"
    if world.matter is not None or world.substances:
        yield ("substances",), "a world with substances"
    if world.reporters:
        yield ("reporters",), "a world with reporters"
    if world.environment:
        yield ("environment",), "a world with environment functions"
    for system in world.systems:
        if not vars(type(system)).get("divisible"):  # a subclass of a divisible system can do more
            yield ("systems",), f"a world with the system {type(system).__name__}"
    if world.recorder is not None and world.recorder.details is not None:
        yield ("record",), "a recording of individual organisms"


def _of_tables(world: SpatialWorld) -> Iterator[tuple[tuple[Any, ...], str]]:
    kinds = {} if world.config is None else {**world.config.objects, **world.config.species}
    for name, table in world.tables.items():
        species, section = table.species, "objects" if table.species.is_object else "species"
        of_features = of_each(kinds[name], "undivided") if name in kinds else ()
        for part, found in (*_of_table(table), *of_features):
            if found:
                yield (
                    (section, name, *part.split(".")),
                    f"{'objects' if species.is_object else 'a species'} {found}",
                )


def _of_table(table: Table) -> Iterator[tuple[str, str]]:
    """Yield a key and a phrase for each feature that cannot be divided; "" means no problem."""
    s, nerves = table.species, table.species.nerves
    yield "body", "without positions" if Position not in table else ""
    yield "body.shape", "of capsules or boxes" if Shape in table else ""
    yield "body", "with solid bodies" if s.body.solid or s.pushed else ""
    way = s.reproduction
    spreads = way is not None and way.kind == "spread"
    yield "genome", "of plants with genes" if spreads and (s.heredity or Growth in table) else ""
    far = (
        s.own_ranges
        or s.own_places
        or any(key.endswith((".reach", ".radius", ".spacing")) for key in s.traits)
    )
    yield "genome", "whose genes set its size, or the reach of its senses or actions" if far else ""
    if s.heredity is not None:
        operators = s.heredity.operators
        variable = s.heredity.layout is not None and s.heredity.layout.longest is not None
        yield "genome", "with strings of variable length" if variable else ""
        yield "genome", "whose genes are shuffled" if s.heredity.shuffled else ""
        own = operators is not None and operators.choice not in range(len(CHOICES))
        yield "genome", "with a custom choice of mates" if own else ""
    for sensor in _sensors(table):
        yield "sensors", f"with a sensor of kind {sensor.kind!r}" if sensor.kind not in SENSES else ""
        yield "sensors", "with a sensor for kin" if getattr(sensor, "kin", None) is not None else ""
    if nerves is None:
        return
    yield "policy", "controlled from outside" if nerves.outside is not None else ""
    learner, minds = nerves.learner, nerves.individuals
    yield (
        "policy.network",
        "with a memory"
        if (nerves.brain is not None and nerves.brain.memory) or (minds is not None and minds.memory)
        else "",
    )
    network = nerves.brain if minds is None else minds
    yield "policy.network", "with a custom network" if network is not None and not network.by_row else ""
    yield (
        "policy",
        "that learns in several worlds"
        if learner is not None and not isinstance(learner, RolloutLearner)
        else "",
    )
    own = s.reflex is not None and s.reflex.function
    yield "reflex.function", "with a custom reflex network" if own else ""
    own = s.happiness is not None and s.happiness.function
    yield "happiness.function", "with a custom happiness network" if own else ""


def require_height(world: SpatialWorld, size: int, least: int, widths: Widths) -> None:
    """Raise a ConfigError if any band's height would be less than the reach of ghosts."""
    ny, side = world.space.shape[1], world.space.size[1] / world.space.shape[1]
    if size > 1 and least * size > ny:
        fault = (
            f"{size} bands would be {world.space.size[1] / size:g} m high, but ghosts reach "
            f"{least * side:g} m: {widths.sensing:g} m for sensing, {widths.acting:g} m for eating, "
            f"mating and births, rounded up to whole cells of {side:g} m"
        )
        raise ConfigError(
            [
                Problem(
                    ("space", "size"),
                    fault,
                    str(list(world.space.size)),
                    f"at most {max(1, ny // least)} processes; or {INSTEAD}",
                )
            ]
        )


def least_height(world: SpatialWorld, widths: Widths) -> int:
    """Return the minimum height of a band in rows of cells, given that ghosts come only from adjacent bands."""
    return max(widths.rows(world))
