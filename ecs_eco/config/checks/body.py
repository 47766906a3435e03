"""Checks of organisms and inanimate objects: bodies, movement, reproduction and features."""

import math
from collections.abc import Iterator

from ecs_eco.config.checks.actions import groups_of_systems
from ecs_eco.config.derived import all_genes
from ecs_eco.config.features.feature import of_each
from ecs_eco.config.models.body import Body
from ecs_eco.config.models.reproduction import Alone, Bearing, Sexual, Spread
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.surroundings import PROPERTIES, ObjectType
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import Key, at_most, extent, inside, named, not_too_fine
from ecs_eco.engine.errors import Problem

MOST_SITES = 10_000_000  # maximum number of plant sites per species
# spheres per spacing^dims above which no more fit at random positions
JAMMED = {2: 0.547 / (math.pi / 4), 3: 0.384 / (math.pi / 6)}


def check_body(config: WorldConfig, name: str) -> Iterator[Problem]:
    """Yield all problems with the species, except those with its nervous system."""
    species, key = config.species[name], ("species", name)
    yield from check_matter(config, key, species)
    yield from check_size(config, key, species.body)
    if species.age is not None and species.age[0] > species.age[1]:
        fault = "the minimum is above the maximum"
        yield Problem((*key, "age"), fault, species.age, f"[{species.age[1]:g}, {species.age[0]:g}]")
    if species.max_count is not None and species.count > species.max_count:
        yield Problem((*key, "count"), "more than max_count", species.count, f"at most {species.max_count}")
    if species.metabolism.energy > species.metabolism.energy_max:
        allowed = f"at most energy_max, {species.metabolism.energy_max:g}"
        yield Problem(
            (*key, "metabolism", "energy"), "more than energy_max", species.metabolism.energy, allowed
        )
    yield from _check_locomotion(config, key, species)
    yield from _check_reproduction(config, key, species)
    yield from of_each(species, "problems", config, key)


def _check_locomotion(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    if species.locomotion is None:
        return
    key, most = (*key, "locomotion"), min(config.space.size) / 2
    for gait, speed in species.locomotion.speed.items():
        if speed * config.dt > most:
            allowed = f"at most {most / config.dt:g} m/s"
            yield Problem(
                (*key, "speed", gait), "moves more than half the world's width in a tick", speed, allowed
            )
    for gait in species.locomotion.cost:
        yield from named((*key, "cost", gait), "gait", gait, species.locomotion.speed)


def _check_reproduction(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    way, at = species.reproduction, (*key, "reproduction")
    if "mate" in species.actions and not isinstance(way, Sexual) and "mate" not in groups_of_systems(config):
        allowed = 'reproduction.kind = "sexual", or remove this action group'
        yield Problem(
            (*key, "actions", "mate"), "it does not reproduce sexually", species.actions["mate"], allowed
        )
    if way is None:
        return
    if isinstance(way, Alone | Spread) and way.rate * config.dt > 1:
        yield Problem(
            (*at, "rate"), "more than one birth per tick", way.rate, f"at most {1 / config.dt:g} per second"
        )
    if way.place == "near" and way.dispersal is None and not isinstance(way, Sexual):
        yield Problem((*at, "dispersal"), 'is missing with place = "near"', allowed="a distance [m]")
    yield from at_most((*at, "dispersal"), config.space.too_wide, way.dispersal or 0.0, config.space.widest)
    if isinstance(way, Bearing):
        most = species.metabolism.energy_max
        fault = "more than energy_max: there would be no births"
        yield from at_most((*at, "energy_min"), fault, way.energy_min, most, "")
        if isinstance(way, Alone) and way.energy_given > way.energy_min:
            allowed = f"at most energy_min, {way.energy_min:g}"
            yield Problem((*at, "energy_given"), "exceeds the parent's minimum", way.energy_given, allowed)
        yield from at_most((*at, "energy_given"), "more than energy_max", way.energy_given, most, "")
    if isinstance(way, Sexual):
        yield from _check_mating(config, key, species, way)
    room, site = _room(config, species), (*at, "spacing")
    if isinstance(way, Spread):
        yield from not_too_fine(site, "ground", way.spacing, config.space.size[:2], MOST_SITES, "sites")
    if species.count > room:
        fault = f"count = {species.count} organisms do not fit: at most {room}"
        yield Problem(site, fault, way.spacing, "a smaller spacing, or fewer organisms")


def _check_mating(config: WorldConfig, key: Key, species: Species, way: Sexual) -> Iterator[Problem]:
    at, most = (*key, "reproduction"), species.metabolism.energy_max
    if species.sex in ("female", "male"):
        fault = "there are no mates: all have the same sex"
        yield Problem((*key, "sex"), fault, species.sex, "random, or none for hermaphrodites")
    yield from at_most((*at, "reach"), config.space.too_wide, way.reach, config.space.widest)
    farthest = (way.dispersal or 4 * species.body.bound) * (1 if config.dims == 2 else math.sqrt(2))
    if way.place == "near" and farthest <= way.spacing:
        fault = "every newborn would be closer than this to its mother"
        yield Problem((*at, "spacing"), fault, way.spacing, f"less than {farthest:g} m")
    elif way.place == "near" and species.body.opaque and farthest <= 2 * species.body.bound:
        allowed = f"more than {2 * species.body.bound:g} m, or body.opaque = false"
        yield Problem((*at, "dispersal"), "the mother's own body blocks every birth", way.dispersal, allowed)
    if way.energy_given > most:
        return
    if way.father_share and way.father_share * way.energy_given * way.litter >= most:
        allowed = f"less than {most / (way.energy_given * way.litter):g}, or a smaller litter"
        fault = "the whole litter costs at least energy_max: no father can pay"
        yield Problem((*at, "father_share"), fault, way.father_share, allowed)
    if way.father_share < 1 and (1 - way.father_share) * way.energy_given >= most:
        allowed = f"less than {most / (1 - way.father_share):g}"
        yield Problem(
            (*at, "energy_given"), "at least energy_max: no mother can pay", way.energy_given, allowed
        )


def _room(config: WorldConfig, species: Species) -> float:
    """Return how many organisms fit on sites or at random positions, given the spacing of newborns."""
    way, size = species.reproduction, config.space.size
    if way is None or way.spacing == 0:
        return math.inf
    if isinstance(way, Spread):
        return math.prod([max(1, round(s / way.spacing)) for s in size[:2]])
    return int(JAMMED[len(size)] * math.prod([max(s / way.spacing, 1.0) for s in size]))


def farthest(config: WorldConfig, species: Species) -> float:
    """Return how far a sensor can be from the center of the largest possible body [body radii]."""
    genes = all_genes(species)
    radii = [x for gene in genes if gene.trait == "body.radius" for x in gene.values or [gene.high or 0.0]]
    radius = max([species.body.radius, *radii])
    return config.space.widest / radius if radius <= min(config.space.size) / 2 else math.inf


def check_matter(config: WorldConfig, key: Key, kind: Species | ObjectType) -> Iterator[Problem]:
    """Yield problems with undeclared properties or substances, and with a missing pressure."""
    for name in kind.properties:
        yield from named((*key, "properties", name), "property", name, PROPERTIES)
    for name in kind.substances:
        yield from named((*key, "substances", name), "substance", name, config.substances)
    if kind.body.compressible and "pressure" not in kind.properties:
        fault = "is missing, but body.compressible changes it"
        allowed = "the initial pressure [Pa], or compressible = false"
        yield Problem((*key, "properties", "pressure"), fault, allowed=allowed)


def check_size(config: WorldConfig, key: Key, body: Body) -> Iterator[Problem]:
    """Yield problems with a body that does not fit in the world."""
    size, at = config.space.size, (*key, "body")
    if body.shape == "sphere":
        fault = "the body does not fit into the world"
        yield from at_most((*at, "radius"), fault, body.radius, min(size) / 2)
        return
    name, most = "length" if body.shape == "capsule" else "size", longest(config)
    if max(body.extents[:2]) > most:
        yield Problem((*at, name), "the body does not fit into the world", allowed=f"at most {most:g} m")
    if len(size) == 3:
        part = (*at, "radius" if body.shape == "capsule" else name)
        yield from at_most(part, "taller than the depth of the world", body.extents[2], size[2])


def longest(config: WorldConfig) -> float:
    """Return the maximum length of a capsule or a box [m]."""
    sides = config.space.size[:2]
    return min(sides) if config.space.edges == "torus" else math.hypot(*sides)


def check_object(config: WorldConfig, name: str, kind: ObjectType) -> Iterator[Problem]:
    """Yield all problems with an object type."""
    key, placed = ("objects", name), [*kind.at, *kind.between]
    if kind.count and placed:
        fault = "given together with `at`" if kind.at else "given together with `between`"
        yield Problem((*key, "count"), fault, kind.count, "either count or a list of objects")
    made = (name in (s.remains, *of_each(s, "makes")) for s in config.species.values())
    if not kind.count and not placed and not any(made):
        allowed = "at least 1, a list `at`, or a species that builds it or leaves it as remains"
        yield Problem((*key, "count"), "no object of this type would ever exist", kind.count, allowed)
    for i, at in enumerate(kind.at):
        yield from inside((*key, "at", i), at, config.space.size)
    if len(kind.heading) not in (0, 1, len(kind.at)):
        fault = f"{len(kind.heading)} headings for {len(kind.at)} positions in `at`"
        yield Problem((*key, "heading"), fault, kind.heading, f"{len(kind.at)} numbers [rad], or one for all")
    elif kind.heading and not kind.at:
        yield Problem((*key, "heading"), "given without `at`", kind.heading, "positions in `at`")
    if kind.renewal and not kind.count:
        fault = "without count, there is no number to restore"
        yield Problem((*key, "renewal"), fault, kind.renewal, "a count of at least 1, or remove renewal")
    yield from _check_ways(config, key, kind)
    yield from check_matter(config, key, kind)
    yield from check_size(config, key, kind.body)
    yield from _check_motion(config, key, kind)
    yield from of_each(kind, "problems", config, key)


def _check_ways(config: WorldConfig, key: Key, kind: ObjectType) -> Iterator[Problem]:
    """Yield problems with objects that extend between two positions."""
    if kind.between and kind.body.shape == "sphere":
        fault = "a sphere cannot extend between two positions"
        yield Problem((*key, "between"), fault, allowed='body.shape = "capsule" or "box", or positions in at')
        return
    size, most = config.space.size[:2], longest(config)
    least = 0.0 if kind.body.shape == "box" else 2 * kind.body.radius
    for i, way in enumerate(kind.between):
        at = (*key, "between", i)
        if not all(0 <= x <= side for x, side in zip(way, size * 2, strict=True)):
            yield Problem(at, "outside the world", way, extent(size))
        elif not least < (length := math.dist(way[:2], way[2:])) <= most:
            yield Problem(
                at, f"{length:g} m from end to end", way, f"more than {least:g} m, at most {most:g} m"
            )


def _check_motion(config: WorldConfig, key: Key, kind: ObjectType) -> Iterator[Problem]:
    """Yield all problems with the motion of an object type."""
    if kind.pushed and not kind.body.solid:
        yield Problem(
            (*key, "pushed"), "objects that are not solid cannot be pushed", True, "body.solid = true"
        )
    motion, size, at = kind.motion, config.space.size, (*key, "motion")
    if motion is None:
        return
    if (motion.velocity is None) == (motion.path is None):
        fault = "give either a velocity or a path"
        yield Problem((*at, "velocity"), fault, allowed="velocity = [1.0, 0.0], or a path and a speed")
    if motion.path is not None and motion.speed is None:
        yield Problem((*at, "speed"), "is missing, but there is a path", allowed="a speed [m/s]")
    if motion.path is None and motion.speed is not None:
        yield Problem((*at, "speed"), "given without a path", motion.speed, "a path, or only a velocity")
    if motion.velocity is not None and len(motion.velocity) != len(size):
        yield Problem(
            (*at, "velocity"), "wrong number of coordinates", motion.velocity, f"{len(size)} numbers"
        )
    for i, place in enumerate(motion.path or ()):
        yield from inside((*at, "path", i), place, size)
    fastest = max(map(abs, motion.velocity or [motion.speed or 0.0]))
    most = min(size) / 2 / config.dt
    yield from at_most(at, "moves more than half the world's width in a tick", fastest, most, " m/s")
