"""World building from a world file: tables with their species' values, nervous systems, and the ordered
list of systems."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import (
    Biology,
    Body,
    Chemistry,
    Memory,
    Metabolism,
    Motor,
    Nervous,
    Parentage,
    Physical,
    Position,
    Sensor,
    Shape,
    Velocity,
)
from ecs_eco.config import WorldConfig, for_training, load
from ecs_eco.config.features.feature import features_of, of_each
from ecs_eco.config.loading import WorldSource
from ecs_eco.config.memory import require_memory
from ecs_eco.config.models.land import RealLand
from ecs_eco.config.models.surroundings import ObjectType
from ecs_eco.config.names import own_features
from ecs_eco.engine.arguments import by_species
from ecs_eco.engine.errors import ConfigError, Problem
from ecs_eco.learning.settings import PPO
from ecs_eco.life.apply import apply, apply_object, begin_learning, cell, learner_seed, matter
from ecs_eco.life.containing import add_matter, contain, keep_books
from ecs_eco.life.founders import newcomers
from ecs_eco.life.heredity import add_heredity
from ecs_eco.life.land import lay
from ecs_eco.life.placed import placed
from ecs_eco.life.treatments import apply as treat
from ecs_eco.nervous.nerves import Nerves
from ecs_eco.nervous.readings import Readings
from ecs_eco.nervous.sensors import senses_of
from ecs_eco.space import Field, Terrain
from ecs_eco.systems.schedule import schedule
from ecs_eco.worlds.policies import (
    Learn,
    Policies,
    fresh_brain,
    load_weights,
    outside_of,
    require_policies,
    source_of,
    sources_in_words,
    take_weights,
    weights_file,
)

if TYPE_CHECKING:
    from ecs_eco.config.models.species import Species
    from ecs_eco.config.models.surroundings import Terrain as TerrainConfig
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def build(
    cls: Any,
    config: WorldSource,
    *,
    seed: int | None = None,
    policies: Policies = "trained",
    threads: int = 1,
    learn: Learn = None,
    training: bool = False,
    populate: bool = True,
    systems: Sequence[Any] = (),
    features: Sequence[Any] = (),
    reporters: Mapping[str, Any] = MappingProxyType({}),
    controls: Sequence[str] = (),
    trust: bool = False,
) -> Any:
    """Return a new world of class `cls`, as `ecs_eco.World.from_config` describes."""
    if not isinstance(config, WorldConfig) or systems or reporters or features or trust:
        config = load(config, systems=systems, reporters=reporters, features=features, trust=trust)
    config._code.require(config._source)
    require_policies(config, policies)
    by_species("learn", learn, config.species, (bool, np.bool_), "true or false")
    config = for_training(config) if training else config
    require_memory(config)
    world = cls(
        config.space.size,
        edges=config.space.edges,
        dt=config.dt,
        seed=config.seed if seed is None else seed,
        cell=config.space.cell or cell(config),
        threads=threads,
        name=config.name,
    )
    world.config = config
    sources = sources_in_words(config, policies)
    world.origin = {"policies": sources, "training": training, "controls": list(controls)}
    if populate and not training:
        one = None if learn is None else bool(learn)
        learns = {name: bool(on) for name, on in learn.items()} if isinstance(learn, Mapping) else one
        world.start = {"policies": sources, "learn": learns, "controls": list(controls)}
    world.reproduction = not (training and config.training.respawn)
    _surroundings(world, config)
    contain(world, config)
    _tables(world, config)
    for number, (name, species) in enumerate(sorted(config.species.items())):
        founder = _networks(world, world.tables[name], species, policies, learn, number, training)
        add_heredity(world, world.tables[name], species, founder)
        _motor(world.tables[name], len(species.ranges()))
    for name, species in config.species.items():
        for feature in features_of(type(species)):
            feature.furnish(species, world.tables[name], world.tables)
    apply(world, config)
    treat(controls, world)
    shipped = schedule(training and config.training.respawn, world.tables.values())
    for system in [*shipped, *_systems_of_features(world, config), *_own_systems(world, config)]:
        world.add_system(system)
    keep_books(world)
    _populate(world, config, populate)
    world.flush()
    return world


def _surroundings(world: SpatialWorld, config: WorldConfig) -> None:
    """Add a world's substances, fields and ground, and the uids of its island."""
    if config.archipelago is not None:
        if config.archipelago.here is None and not world.origin["training"]:  # which uses one world
            names, fault = ", ".join(config.archipelago.names), "defines several worlds"
            allowed = "a world without islands; run islands with `ecs-eco run` or ecs_eco.lab.Archipelago"
            raise ConfigError([Problem(("archipelago",), fault, names, allowed)])
        world.next_uid = config.archipelago.first_uid
    world.substances = list(config.substances)
    world.fields = {name: Field(world.space, f.cell) for name, f in sorted(config.fields.items())}
    if config.terrain is not None:
        real = set(RealLand.model_fields)
        t = config.terrain.model_dump(exclude_none=True, exclude=real)
        world.terrain = Terrain(world.space, t.pop("cell"), **t)
        if config._land is not None:
            lay(world.terrain, config._land, config.terrain)


def _tables(world: SpatialWorld, config: WorldConfig) -> None:
    """Return the tables of a world by name, objects first, still empty."""
    for name, kind in sorted(config.objects.items()):
        dims = {"substances": len(world.substances)}
        capacity = max(16, kind.count + len(kind.at) + len(kind.between))
        table = world.add_table(name, Position, Body, dims=dims, capacity=capacity)
        apply_object(table, kind, world.substances)
    for name, species in sorted(config.species.items()):
        _species_table(world, name, species)
    for name, species in sorted(config.species.items()):
        _remains(world, world.tables[name], species.remains)
    add_matter(world, config)
    if config.terrain is not None:
        _landmarks(world, config.terrain)


def _systems_of_features(world: SpatialWorld, config: WorldConfig) -> list[Any]:
    """Return the systems of custom features, except systems that no table requests."""
    systems = dict.fromkeys(system for feature in own_features(config) for system in feature.systems)
    tables = world.tables.values()
    return [s() for s in systems if s.asked_for is None or any(map(s.asked_for, tables))]


def _own_systems(world: SpatialWorld, config: WorldConfig) -> list[Any]:
    """Return the systems that the world names; classes are instantiated with the given parameters."""
    named = [config.function(system) for system in config.systems]
    world.own_systems = [made() if isinstance(made, type) else made for made in named]
    return world.own_systems


def _landmarks(world: SpatialWorld, terrain: TerrainConfig) -> None:
    """Create an inanimate object for every mountain, rock and lake: a table for each kind, named after it if
    the name is free.

    The ground itself blocks walkers and sight; these objects only provide positions for `each`, viewers and
    user systems.
    """
    for kind in ("mountains", "rocks", "lakes"):
        places = getattr(terrain, kind)
        if not places or kind in world.config.objects or kind in world.config.species:
            continue
        table = world.add_table(kind, Position, Body, capacity=len(places))
        table.species.radius = max(p.radius for p in places)
        body = {"radius": table.species.radius, "opaque": False}
        table.species.section = ObjectType.model_validate({"body": body, "color": "#4477aa"})
        columns = {
            (Position, "x"): [p.at[0] for p in places],
            (Position, "y"): [p.at[1] for p in places],
            (Body, "radius"): [p.radius for p in places],
        }
        table.request(
            np.zeros(len(places), np.uint64), {k: np.array(v, np.float32) for k, v in columns.items()}
        )


def _remains(world: SpatialWorld, table: Table, remains: str | None) -> None:
    """Give the remains of a species' dead the substances of its bodies."""
    if remains is not None:
        into = world.tables[remains]
        for component in (Physical, Chemistry, Shape):
            if component in table and component not in into:
                into.add_component(component)
        into.species.radius = max(into.species.radius, table.species.radius)


def _species_table(world: SpatialWorld, name: str, species: Species) -> None:
    actions = species.action_list()
    table = world.add_table(
        name,
        Position,
        Body,
        Metabolism,
        Biology,
        capacity=max(64, int(species.count * 1.5)),
        dims={"substances": len(world.substances), "actions": len(actions)},
    )
    matter(table, species, world.substances)  # its columns precede the columns of the nervous system
    if species.sensors or actions:
        table.add_component(Nervous)
        dims = world.config.dims
        senses = senses_of(species, dims, world.substances, world.config.function, world.config.bearers)
        table.species.nerves = Nerves(
            species.channels(dims),
            senses,
            species.groups(),
            species.default_action,
            species.always_on,
            species.readings(dims),
            species.ranges(),
        )
        table.derived[Sensor] = Readings(table)
    if species.locomotion is not None and table.species.nerves is not None:
        table.add_component(Velocity)
    for other, component in of_each(species, "brings"):
        holder = table if other is None else world.tables[other]
        if component not in holder:
            holder.add_component(component)
    if name in world.config.have_parents():
        table.add_component(Parentage)


def _networks(
    world: SpatialWorld,
    table: Table,
    species: Species,
    policies: Policies,
    learn: Learn,
    number: int,
    training: bool,
) -> np.ndarray | None:
    """Create the policy networks of one species; return the weights that all founders share, if any."""
    nerves = table.species.nerves
    if nerves is None or species.policy.kind == "none" or not nerves.choices:
        return None
    nerves.policy = True
    if not species.policy.thinks:
        nerves.outside = outside_of(world, table.name, species.policy)
        return None
    source = source_of(policies, table.name)
    if source == "random":
        return None
    seed = learner_seed(world.seed, number)
    # pre-training trains one policy for the whole species
    alone = species.policy.kind == "individual" and not training
    shape = len(nerves.channels), nerves.choices, tuple(species.policy.hidden)
    path = weights_file(world.config, table.name, source) if isinstance(source, str | Path) else None
    brain = None
    if not alone or path is not None or not isinstance(source, str | Path):
        brain = fresh_brain(world.config, table.name, species.policy, shape, seed)
    if path is not None and brain is not None:
        load_weights(brain, path, world.config, table.name)
    elif brain is not None and not isinstance(source, str | Path):
        take_weights(brain, source, table.name)
    chosen = learn.get(table.name) if isinstance(learn, Mapping) else learn
    nerves.learning = species.policy.learn if chosen is None else chosen
    if nerves.learning and species.happiness is None:
        fault, allowed = "has no reward", "a learning species with `happiness`; or learn = false"
        raise ConfigError([Problem(("species", table.name, "policy", "learn"), fault, True, allowed)])
    if alone:
        ppo = PPO(**species.ppo)
        nerves.individuals = fresh_brain(world.config, table.name, species.policy, shape, seed, ppo)
        return None if brain is None else nerves.individuals.flat(brain)
    assert brain is not None
    nerves.brain = brain
    if brain.memory:
        table.dims["memory"] = brain.memory
        table.add_component(Memory)
    if nerves.learning:
        begin_learning(world, table)
    return None


def _motor(table: Table, continuous: int) -> None:
    """Give a table the component for continuous actions, after that of learning, which sets its horizon."""
    if continuous:
        table.dims = {"horizon": 0} | table.dims | {"continuous": continuous}
        table.add_component(Motor)


def _populate(world: SpatialWorld, config: WorldConfig, populate: bool) -> None:
    """Request the first organisms and objects; or none, not even landmarks."""
    if populate:
        kinds: dict[str, ObjectType | Species] = {**config.objects, **config.species}
        for name, kind in kinds.items():
            _request(world, world.tables[name], kind)
    else:
        for table in world.tables.values():
            table.births.clear()


def _request(world: SpatialWorld, table: Table, kind: ObjectType | Species) -> None:
    """Request the first entities of one kind: at the given positions, the rest at random."""
    if isinstance(kind, ObjectType):
        for values in placed(kind, world.space):
            table.request(np.zeros(values[Position, "x"].size, np.uint64), values)
    if kind.count:
        identity = np.arange(1, kind.count + 1, dtype=np.uint64)
        values = newcomers(table, world, kind, identity)
        table.request(np.zeros(values[Position, "x"].size, np.uint64), values)
