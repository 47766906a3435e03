"""New values for a living world: its configuration may change while organisms live, learn and die."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ecs_eco.components import Experience, Policy
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.mutable_keys import changes, refused
from ecs_eco.engine.errors import ConfigError
from ecs_eco.engine.interruption import require_whole, whole
from ecs_eco.worlds.apply_species import (
    apply_species,
    apply_surroundings,
    begin_learning,
    cell,
    learner_seed,
    matter,
    settings,
    trains,
)

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


def reconfigure(world: SpatialWorld, config: Any, learners: Iterable[str] = ()) -> None:
    """Give a living world another configuration: from now on it behaves as if built with it.

    Organisms keep the state that they were born with (energy, mass, sex, fertility, properties, substances);
    newborn get the new values. A species that stops learning discards the experience not yet learnt from; one
    that begins starts with none. `learners` are species whose `learn` follows the new configuration even if
    the world was built with another. Raises ConfigError that names each value that cannot change in a living
    world, before anything changes.
    """
    require_whole(world, "change values", within=True)
    if world.config is None:
        raise RuntimeError("this world was made by hand, without a configuration: "
                           "set what its systems read instead")
    new, old = config if isinstance(config, WorldConfig) else load(config), world.config
    new._code.require(new._source)
    if problems := refused(old, new):
        n = len(problems)
        raise ConfigError(problems,
                          f"the world {world.name!r} lives: {n} value{'s' if n > 1 else ''} cannot change")
    with whole(world, "a change of values"):
        _apply(world, old, new)
        for name in learners:
            learning(world, world.tables[name])


def _apply(world: SpatialWorld, old: WorldConfig, new: WorldConfig) -> None:
    changed = [key for key, _, _ in changes(old.model_dump(), new.model_dump())]
    world.config = new
    apply_surroundings(world, new, changed)
    if ("seed",) in changed:
        reseed(world, new.seed)
    of_species = any(key[0] == "species" for key in changed)
    if of_species and new.space.cell is None and cell(new) != world.space.cell:
        world.space.set_cell(cell(new))
        world.forget_neighbours()
    for name in dict.fromkeys(str(key[1]) for key in changed if key[0] in ("objects", "species")):
        mine = {".".join(map(str, key[2:]))
                for key in changed if key[:2] in (("species", name), ("objects", name))}
        if name in new.objects:
            matter(world.tables[name], new.objects[name], world.substances)
        else:
            _species(world, world.tables[name], old.species[name], new.species[name], mine)
    _causes(world)
    world.touch()


def reseed(world: SpatialWorld, seed: int) -> None:
    """Change the seed of all random numbers from the next tick on."""
    world.seed = seed
    for number, name in enumerate(() if world.config is None else world.config.species):
        nerves = world.tables[name].species.nerves
        for learning in (getattr(nerves, "learner", None), getattr(nerves, "individuals", None)):
            if learning is not None:
                learning.seed = learner_seed(seed, number)


def _species(world: SpatialWorld, table: Table, old: Any, new: Any, changed: set[str]) -> None:
    """Apply the values of one species; `changed` are the keys that differ."""
    parts = {key.partition(".")[0] for key in changed}
    apply_species(world, table, new, parts)
    nerves, heredity = table.species.nerves, table.species.heredity
    if nerves is not None and "ppo" in parts:
        _settings(nerves, new, trains(world))
    if nerves is not None and "policy.learn" in changed:
        learning(world, table)
    if heredity is not None:
        heredity.inherit, heredity.noise = new.policy.inherit, float(new.policy.mutation)
    _genes(world, table, old, new, changed)


def _settings(nerves: Any, species: Any, training: bool) -> None:
    """Change the hyperparameters of learners."""
    ppo = settings(species.ppo, training)
    if nerves.learner is not None:
        nerves.learner.ppo = ppo
        nerves.learner.rollout.discount = ppo.discount
    if nerves.individuals is not None:
        nerves.individuals.reset(ppo)


def learning(world: SpatialWorld, table: Table) -> None:
    """Let a species begin to learn, or stop, as its `policy.learn` says."""
    nerves, species = table.species.nerves, table.species.config
    if nerves.brain is None and nerves.individuals is None:
        return  # a random policy, which cannot learn
    if nerves.learning == species.policy.learn:
        return
    nerves.learning = species.policy.learn
    if nerves.individuals is not None:
        _experience(table, nerves.learning)
    elif nerves.learning:
        begin_learning(world, table)
    else:
        nerves.learner = None


def _experience(table: Table, wanted: bool) -> None:
    """Add the columns that individual learning needs, beside the policies; or remove them."""
    table.columns.pop(Experience, None)
    table.defaults.pop(Experience, None)
    table.renew_handles()
    if not wanted:
        return
    table.add_component(Experience)
    columns: Any = (table.columns, table.defaults)
    for held in columns:  # in the order in which a world is built
        order = [c for c in held if c is not Experience]
        order.insert(order.index(Policy) + 1, Experience)
        for component in order:
            held[component] = held.pop(component)


def _genes(world: SpatialWorld, table: Table, old: Any, new: Any, changed: set[str]) -> None:
    """Apply values that have columns but no gene; and new operators where the genome has changed."""
    if new.genome is None:
        return
    from ecs_eco.config.traits import traits_of

    own, known = [world.config.function(c) for c in new.components], {c.__name__: c for c in table.columns}
    before, now = (traits_of(s, world.config.dims, own) for s in (old, new))
    for name, trait in now.items():
        lives = trait.component in known and trait.component not in ("Policy", "Body")
        if lives and name in before and before[name].default != trait.default:
            component, at = known[trait.component], ... if trait.index is None else trait.index
            table.defaults[component][trait.field][at] = trait.default
            column = table.field(component, trait.field)
            column[(table.rows(), *(() if trait.index is None else (trait.index,)))] = trait.default
    if any(key.startswith(("genome.", "reproduction.choice")) for key in changed):
        from ecs_eco.genomes import Operators

        heredity = table.species.heredity
        choice = getattr(new.reproduction, "choice", "nearest")
        heredity.operators = Operators.from_config(new.genome, heredity.layout, choice, world.config.function)


def _causes(world: SpatialWorld) -> None:
    """Register new causes of death, in the order of species."""
    for table in world.tables.values():
        for food in table.species.diet:
            world.cause(f"eaten by {table.name}")
            if food.deadly:
                world.cause(f"poisoned by {food.eats}")
        for limit in table.species.lethal:
            for cause, bound in ((limit.low, limit.min), (limit.high, limit.max)):
                if bound is not None:
                    world.cause(cause)
