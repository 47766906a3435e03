"""Apply the values of a world file to a world: all of them when the world is built, and those that differ
when an intervention or a fork reconfigures it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import (
    Biology,
    Body,
    Chemistry,
    HeatExchange,
    Metabolism,
    Physical,
    Route,
    Shape,
    Stature,
)
from ecs_eco.config import WorldConfig
from ecs_eco.config.checks.reporters import formula_of, is_formula
from ecs_eco.config.derived import all_genes
from ecs_eco.config.models.species import MOTIONS
from ecs_eco.config.mutable_keys import Key, changes
from ecs_eco.engine import random
from ecs_eco.inputs.code import handed_over
from ecs_eco.learning.brains import learner_of
from ecs_eco.learning.settings import PPO
from ecs_eco.life.gaits import Gaits
from ecs_eco.life.heredity import apply_heredity
from ecs_eco.life.sizes import masses_differ
from ecs_eco.nervous.networks import HappinessNetwork, ReflexNetwork
from ecs_eco.space.sun import Sun
from ecs_eco.space.water import Water
from ecs_eco.space.year import Year

if TYPE_CHECKING:
    from ecs_eco.config.models.energy import Locomotion
    from ecs_eco.config.models.species import Species
    from ecs_eco.config.models.surroundings import ObjectType
    from ecs_eco.engine.table import Table
    from ecs_eco.life.kind import Kind
    from ecs_eco.nervous.nerves import Nerves
    from ecs_eco.space.world import SpatialWorld

SEXES = {"none": 0, "female": 1, "male": 2, "random": 0}


def apply(world: SpatialWorld, config: WorldConfig, before: WorldConfig | None = None) -> None:
    """Set all values of a configuration that can change in a live world; if the world has the configuration
    `before`, set only those that differ.

    Tables, their columns and policies already exist. Newborns get the new values; living organisms keep their
    state at birth, except for individual traits that no gene codes for.
    """
    changed = None if before is None else [k for k, *_ in changes(before.model_dump(), config.model_dump())]
    world.config = config
    world.reporters |= {
        name: formula_of(config, what) if is_formula(what) else config.function(what)
        for name, what in config.reporters.items()
    }
    apply_surroundings(world, config, changed)
    for use in config.land_use:
        world.tables[use.species].species.used = True
    for name, kind in config.objects.items():
        if changed is None or any(key[:2] == ("objects", name) for key in changed):
            apply_object(world.tables[name], kind, world.substances)
    for name, species in config.species.items():
        keys = (
            None
            if changed is None
            else {".".join(map(str, key[2:])) for key in changed if key[:2] == ("species", name)}
        )
        if keys is None or keys:
            apply_species(world, world.tables[name], species, keys)
            apply_heredity(
                world, world.tables[name], species, keys, None if before is None else before.species[name]
            )


def apply_surroundings(
    world: SpatialWorld, config: WorldConfig, changed: Collection[Key] | None = None
) -> None:
    """Configure the surroundings of all organisms: ambient values, sun, water and year, smells, slopes.

    Sets everything if `changed` is None, otherwise only the configuration keys in it, so that settings made
    by the user are preserved.
    """

    def wanted(*key: str) -> bool:
        return changed is None or any(k[: len(key)] == key for k in changed)

    for quantity, value in config.ambient.model_dump().items():
        if wanted("ambient", quantity):
            world.ambient[quantity] = value
    if wanted("sun") or wanted("water") or wanted("year"):
        climate(world, config)
    for name, field in config.fields.items():
        for coefficient in ("diffusion", "decay", "renewal"):
            if wanted("fields", name, coefficient):
                setattr(world.fields[name], coefficient, getattr(field, coefficient) or 0.0)
    if config.terrain is not None and world.terrain is not None and wanted("terrain", "slope_cost"):
        world.terrain.slope_cost = float(config.terrain.slope_cost)


def climate(world: SpatialWorld, config: WorldConfig) -> None:
    """Give a world its sun, water and year: functions of the environment that replace constants."""
    year = None if config.year is None else Year(**config.year.model_dump())
    sun = None if config.sun is None else Sun(**config.sun.model_dump())
    if sun is not None and year is not None:
        sun.year, sun.spring = year.length, year.start
    elif sun is not None and sun.year is not None:
        year = Year(sun.year)
    water = None
    if config.water is not None:
        given = config.water.model_dump(exclude={"shading", "current", "current_function"})
        current = [(c.depth, c.velocity[0], c.velocity[1]) for c in config.water.current]
        water = Water(config.space.size, current=current, **given)
    world.environment.set_climate(sun, water, year)


def matter(table: Table, kind: ObjectType | Species, substances: list[str]) -> None:
    """Set mass, size, shape, physical and chemical properties of newborns, and the heat exchange of bodies."""
    table.set_defaults(Body, radius=kind.body.radius, mass=kind.body.mass)
    if kind.body.shape != "sphere":
        table.add_component(Shape, **kind.body.form)
    if table.species.radius is None:
        table.species.radius = kind.body.radius
    if kind.properties:
        table.add_component(Physical, **kind.properties)
    if kind.heat is not None:
        table.add_component(HeatExchange)
    if kind.substances:
        table.add_component(Chemistry, molarity=[kind.substances.get(s, 0.0) for s in substances])


def apply_object(table: Table, kind: ObjectType, substances: list[str]) -> None:
    """Set the properties and the energy of one type of object."""
    table.species.section = kind
    matter(table, kind, substances)
    if kind.motion is not None:
        table.add_component(Route)
    if kind.energy is not None:
        table.add_component(Metabolism)
        table.set_defaults(Metabolism, energy=kind.energy.initial)


def apply_species(
    world: SpatialWorld, table: Table, species: Species, changed: Collection[str] | None = None
) -> None:
    """Set the initial values of a species' newborns, and the values that systems read.

    Rebuilds gaits and networks if `changed` is None or contains one of their dotted keys.
    """
    parts = None if changed is None else {key.partition(".")[0] for key in changed}
    kind: Kind = table.species
    nerves, had_reflex = kind.nerves, kind.reflex is not None
    kind.section = species
    matter(table, species, world.substances)
    table.set_defaults(Metabolism, energy=species.metabolism.energy)
    immature = species.breeding is not None and species.breeding.maturity > 0
    table.set_defaults(Biology, sex=SEXES[species.sex], fertility=0.0 if immature else species.fertility)
    if species.growth is not None:
        table.add_component(Stature, radius=species.body.radius, mass=species.body.mass)
    kind.standard_mass = species.body.mass if masses_differ(species) else None
    if nerves is None:
        return
    if species.locomotion is not None and (parts is None or "locomotion" in parts):
        kind.gaits = gaits(species.locomotion, nerves)
    if parts is None or not {"reflex", "happiness"}.isdisjoint(parts):
        taken_away = had_reflex and nerves.reflex is None
        networks(nerves, species, world.config.function)
        if taken_away:  # removed by a treatment, which remains in force
            nerves.reflex = None


def gaits(way: Locomotion, nerves: Nerves) -> Gaits:
    """Return the layout i64[4, 3], the speeds, costs, turns, climbs and pitches of locomotion actions, and
    the drag; for a continuous speed, all gaits from slow to fast."""
    layout = np.tile(np.array([0, 0, -1], np.int64), (4, 1))
    rows = []
    for i, group in enumerate(MOTIONS):
        names = nerves.groups.get(group, [])
        if group in nerves.ranges.groups:
            layout[i] = nerves.ranges.groups.index(group), -1, -1
            names = sorted(way.speed, key=way.speed.__getitem__) if group == "speed" else []
        elif names:
            layout[i] = (*nerves.columns[group], nerves.neutral[group])
        rows.append(names)
    speeds, turns, climbs, _ = rows
    turning = {"left": way.turn, "right": -way.turn}
    climbing, pitching = {"up": way.climb, "down": -way.climb}, {"up": way.pitch, "down": -way.pitch}
    arrays = (
        [way.speed.get(a, 0.0) for a in speeds],
        [way.cost.get(a, 0.0) for a in speeds],
        [turning.get(a, 0.0) for a in turns],
        [climbing.get(a, 0.0) for a in climbs],
        [pitching.get(a, 0.0) for a in climbs],
    )
    columns = (np.array(a or [0.0], np.float32) for a in arrays)
    return Gaits._make((layout, *columns, np.float32(way.drag)))


def networks(nerves: Nerves, species: Species, find: Callable[[Any], Any] = handed_over) -> None:
    """Give a nervous system any reflex and happiness networks that its species declares; `find` works like
    `WorldConfig.function`."""
    inherited = {gene.trait.partition(".")[0] for gene in all_genes(species) if gene.trait}
    nerves.reflex = nerves.happiness = None
    if species.reflex is not None:
        nerves.reflex = ReflexNetwork(
            species.reflex,
            nerves,
            species.action_rows(),
            not inherited.isdisjoint(("reflex", "actions")),
            find,
        )
    if species.happiness is not None:
        nerves.happiness = HappinessNetwork(species.happiness, nerves, "happiness" in inherited, find)
        nerves.minimum = np.float32(species.happiness.minimum)


def begin_learning(world: SpatialWorld, table: Table) -> None:
    """Give a species with one shared policy a new learner, without experience."""
    nerves, species = table.species.nerves, world.config.species[table.name]
    assert nerves is not None
    number = sorted(world.config.species).index(table.name)
    nerves.learner = learner_of(
        nerves.brain, PPO(**species.ppo), seed=learner_seed(world.seed, number), workers=world.threads
    )


def learner_seed(seed: int, number: int) -> int:
    """Return the seed for the networks of species `number` in a world with this seed."""
    return (random.mix_int(seed) + number) & 0x7FFFFFFFFFFFFFFF


def cell(config: WorldConfig) -> float:
    """Set the side length of the index cells to half the largest sensor range, so that a search covers about
    5 × 5 cells."""
    radii = [getattr(s, "range", 0.0) for sp in config.species.values() for s in sp.sensors]
    if not radii:
        radii = [getattr(sp.reproduction, "reach", 0.0) for sp in config.species.values()]
    shortest = min(config.space.size)
    return min(max(max(radii, default=0.0) / 2, shortest / 500), shortest)
