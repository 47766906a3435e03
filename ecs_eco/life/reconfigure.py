"""New values for a live world: the configuration can change while organisms live, learn and die."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ecs_eco.components import Experience, Policy
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.loading import WorldSource
from ecs_eco.config.mutable_keys import refused
from ecs_eco.engine.errors import ConfigError
from ecs_eco.engine.interruption import require_whole, whole
from ecs_eco.learning.settings import PPO
from ecs_eco.life.apply import apply, begin_learning, cell, learner_seed
from ecs_eco.life.causes import register_eaters, register_limits
from ecs_eco.life.parameters import kept_elsewhere, set_parameters

if TYPE_CHECKING:
    from ecs_eco.config.models.species import Species
    from ecs_eco.engine.table import Table
    from ecs_eco.nervous.nerves import Nerves
    from ecs_eco.space.world import SpatialWorld


def reconfigure(world: SpatialWorld, config: WorldSource, learners: Iterable[str] = ()) -> None:
    """Give a live world a new configuration, effective from the next tick.

    Living organisms keep their current state (energy, mass, sex, fertility, properties, substances); newborns
    get the new values. A species that stops learning discards experience that it has not yet learned from; a
    species that begins to learn starts without experience.

    Parameters
    ----------
    world : World
        A world that was built from a configuration.
    config : str, Path, Mapping or WorldConfig
        The new configuration.
    learners : iterable of str
        Species whose `policy.learn` follows the new configuration even if the world was built with a
        different setting.

    Raises
    ------
    ConfigError
        If a value cannot change in a live world; the error lists each such value, and nothing has changed.
    RuntimeError
        If the world was built by hand.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.config import load
    >>> from ecs_eco.life.reconfigure import reconfigure
    >>> world = World.from_config("predator-prey", seed=1)
    >>> reconfigure(world, load("predator-prey", {"species.wolf.locomotion.speed.run": 1.5}))
    """
    require_whole(world, "change values", within=True)
    if world.config is None:
        raise RuntimeError(
            "this world was built by hand, without a configuration: set the values that its systems read instead"
        )
    new, old = config if isinstance(config, WorldConfig) else load(config), world.config
    new._code.require(new._source)
    if problems := refused(old, new) + kept_elsewhere(world, new):
        n = len(problems)
        raise ConfigError(
            problems, f"{n} value{'s' if n > 1 else ''} cannot change in the live world {world.name!r}"
        )
    with whole(world, "a change of values"):
        set_parameters(world, new)
        _apply(world, old, new)
        for name in learners:
            learning(world, world.tables[name])


def _apply(world: SpatialWorld, old: WorldConfig, new: WorldConfig) -> None:
    apply(world, new, old)
    if new.seed != old.seed:
        reseed(world, new.seed)
    if new.space.cell is None and cell(new) != cell(old):
        world.space.set_cell(cell(new))
        world._forget_neighbours()
    for name, species in new.species.items():
        _learners(world, world.tables[name], old.species[name], species)
    for table in world.tables.values():
        register_eaters(world, table)
        register_limits(world, table)
    world._touch()


def reseed(world: SpatialWorld, seed: int) -> None:
    """Change the seed of all random draws from the next tick on."""
    world.seed = seed
    for number, name in enumerate(() if world.config is None else world.config.species):
        nerves = world.tables[name].species.nerves
        for learning in (getattr(nerves, "learner", None), getattr(nerves, "individuals", None)):
            if learning is not None:
                learning.seed = learner_seed(seed, number)


def _learners(world: SpatialWorld, table: Table, old: Species, new: Species) -> None:
    """Give learners new settings, and start or stop learning as configured."""
    nerves = table.species.nerves
    if nerves is None:
        return
    if new.ppo != old.ppo:
        _settings(nerves, new)
    if new.policy.learn != old.policy.learn:
        learning(world, table)


def _settings(nerves: Nerves, species: Species) -> None:
    """Change the hyperparameters of learners."""
    ppo = PPO(**species.ppo)
    if nerves.learner is not None:
        nerves.learner.ppo = ppo
        nerves.learner.rollout.discount = ppo.discount
    if nerves.individuals is not None:
        nerves.individuals.reset(ppo)


def learning(world: SpatialWorld, table: Table) -> None:
    """Start or stop learning in a species, as its `policy.learn` requires."""
    nerves, wanted = table.species.nerves, table.species.policy.learn
    if nerves.brain is None and nerves.individuals is None:
        return  # a random policy, which cannot learn
    if nerves.learning == wanted:
        return
    nerves.learning = wanted
    if nerves.individuals is not None:
        _experience(table, nerves.learning)
    elif nerves.learning:
        begin_learning(world, table)
    else:
        nerves.learner = None


def _experience(table: Table, wanted: bool) -> None:
    """Add the columns that individual learning needs, next to the policies, or remove them."""
    table.columns.pop(Experience, None)
    table.defaults.pop(Experience, None)
    table.renew_handles()
    if not wanted:
        return
    table.add_component(Experience)
    columns: Any = (table.columns, table.defaults)
    for held in columns:  # in the same order as when a world is built
        order = [c for c in held if c is not Experience]
        order.insert(order.index(Policy) + 1, Experience)
        for component in order:
            held[component] = held.pop(component)
