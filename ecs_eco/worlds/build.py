"""From a world file to a World: tables with their species' values, nervous systems, and the list of systems in order."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco import random
from ecs_eco.components import Biology, Body, Chemistry, Metabolism, Nervous, Physical, Position, Velocity
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.base import named_function
from ecs_eco.errors import ConfigError, Problem, listed, nearest
from ecs_eco.nervous.nerves import Nerves
from ecs_eco.nervous.networks import HappinessNetwork, ReflexNetwork
from ecs_eco.nervous.senses import senses_of
from ecs_eco.space import Field, Terrain
from ecs_eco.systems.respawn import scatter
from ecs_eco.worlds.controls import apply
from ecs_eco.worlds.heredity import add_heredity, flat

SEXES = {"none": 0, "female": 1, "male": 2, "random": 0}
POLICIES = ("trained", "random", "untrained")


def schedule(respawn: bool = False) -> list[Any]:
    """Return the systems of a world in the order of a tick."""
    from ecs_eco import systems as s

    return [
        s.Reckon(), s.Grow(), s.Diffuse(),  # environment
        s.Sense(), s.Feel(), s.Learn(), s.Decide(), s.Move(),  # nerves
        s.Collide(), s.Feed(), s.Mate(),  # interact
        s.Metabolise(), s.Age(),
        s.Perish(), s.Leave(),  # die
        *([s.Respawn()] if respawn else [s.Reproduce(), s.Bear()]), s.Spread(),
    ]  # fmt: skip


def build(cls: Any, config: Any, *, seed: int | None = None, policies: Any = "trained", threads: int = 1, learn: Any = None,
          training: bool = False, record: bool = True, populate: bool = True, systems: Sequence[Any] = (),
          controls: Sequence[str] = ()) -> Any:
    """Return a new world.

    `policies`: "trained" (the files that the world names; untrained where it names none), "random" (every action with
    equal chance), "untrained" (fresh networks), a folder of <species>.safetensors, or a dict species → one of these.
    `learn` overrides the species' own `policy.learn`: true, false, or a dict species → these. `populate`: whether there
    are organisms at the start. `training`: numbers held constant by respawn, no births.
    `systems` are added to those of the world file, each at the end of its phase. `controls` are names of
    `ecs_eco.worlds.controls`: what is taken away so that its part can be told.
    Raises ConfigError for a configuration that is wrong.
    """
    config = config if isinstance(config, WorldConfig) and not systems else load(config, systems=systems)
    if training:
        config = config.for_training()
    world = cls(config.space.size, edges=config.space.edges, dt=config.dt, seed=config.seed if seed is None else seed,
                cell=config.space.cell or _cell(config), threads=threads, name=config.name)
    world.config = config
    sources = {name: policies.get(name, "trained") if isinstance(policies, dict) else policies for name in config.species}
    world.origin = {"policies": {name: str(source) for name, source in sources.items()}, "training": training, "controls": list(controls)}
    world.substances = list(config.substances)
    world.ambient = config.ambient.model_dump()
    world.reproduction = not (training and config.training.respawn)
    world.fields = {name: Field(world.space, f.cell, f.diffusion, f.decay) for name, f in config.fields.items()}
    if config.terrain is not None:
        t = config.terrain.model_dump(exclude_none=True)
        world.terrain = Terrain(world.space, t.pop("cell"), **t)
    for name, kind in config.objects.items():
        _object_table(world, name, kind)
    for name, species in config.species.items():
        _species_table(world, name, species)
    for table in list(world.tables.values()):
        _remains(world, table)
    if config.terrain is not None:
        _landmarks(world, config.terrain)
    for number, (name, species) in enumerate(config.species.items()):
        founder = _networks(world, world.tables[name], species, policies, learn, number, training)
        add_heredity(world, world.tables[name], species, founder)
    apply(controls, world)
    for system in [*schedule(training and config.training.respawn), *_own_systems(config)]:
        world.add_system(system)
    for name, kind in [*config.objects.items(), *config.species.items()] if populate else ():
        _populate(world, world.tables[name], kind)
    if not populate:
        for table in world.tables.values():
            table.births.clear()
    world.flush()
    if record:
        from ecs_eco.record.recorder import Recorder

        Recorder(world)
    return world


def _own_systems(config: WorldConfig) -> list[Any]:
    """Return the systems that the world names: a class, or what else can be called, makes a new one."""
    found = [named_function(system) for system in config.systems]
    return [system() if callable(system) else system for system in found]


def _cell(config: WorldConfig) -> float:
    """Choose the side of the index cells: half the widest sense, so that a look takes about 5 × 5 of them."""
    radii = [getattr(s, "radius", 0.0) for sp in config.species.values() for s in sp.sensors]
    if not radii:
        radii = [getattr(sp.reproduction, "reach", 0.0) for sp in config.species.values()]
    shortest = min(config.space.size)
    return min(max(max(radii, default=0.0) / 2, shortest / 500), shortest)


def _landmarks(world: Any, terrain: Any) -> None:
    """Make an inanimate object of every mountain, rock and lake: a table of each kind, named so unless the world uses the name.

    The ground stops and hides; these only say what is where, for `each`, viewers and systems of one's own.
    """
    for kind in ("mountains", "rocks", "lakes"):
        places = getattr(terrain, kind)
        if not places or kind in world.config.objects or kind in world.config.species:
            continue
        table = world.add_table(kind, Position, Body, capacity=len(places))
        table.traits |= {"object": True, "opaque": False, "solid": False, "radius": max(p.radius for p in places), "color": "#888888"}
        columns = {(Position, "x"): [p.at[0] for p in places], (Position, "y"): [p.at[1] for p in places],
                   (Body, "radius"): [p.radius for p in places]}
        table.request(np.zeros(len(places), np.uint64), {k: np.array(v, np.float32) for k, v in columns.items()})


def _matter(table: Any, kind: Any, substances: list[str]) -> None:
    """Set mass, radius, physical and chemical properties that a newborn has."""
    table.set_defaults(Body, radius=kind.body.radius, mass=kind.body.mass)
    table.traits |= {"opaque": kind.body.opaque, "solid": kind.body.solid, "radius": kind.body.radius, "color": kind.color}
    if kind.properties:
        table.add_component(Physical, **kind.properties)
    if kind.substances:
        table.add_component(Chemistry, molarity=[kind.substances.get(s, 0.0) for s in substances])


def _object_table(world: Any, name: str, kind: Any) -> None:
    table = world.add_table(name, Position, Body, dims={"substances": len(world.substances)}, capacity=max(16, kind.count + len(kind.at)))
    _matter(table, kind, world.substances)
    table.traits["object"] = True


def _remains(world: Any, table: Any) -> None:
    """Give the objects that the dead of a species become what its bodies are made of."""
    if (name := table.traits.get("remains")) is not None:
        into = world.tables[name]
        for component in (Physical, Chemistry):
            if component in table and component not in into:
                into.add_component(component)
        into.traits["radius"] = max(into.traits["radius"], table.traits["radius"])


def _species_table(world: Any, name: str, species: Any) -> None:
    actions = species.action_list()
    table = world.add_table(name, Position, Body, Metabolism, Biology, capacity=max(64, int(species.count * 1.5)),
                            dims={"substances": len(world.substances), "actions": len(actions)})
    _matter(table, species, world.substances)
    table.set_defaults(Metabolism, energy=species.metabolism.energy)
    table.set_defaults(Biology, sex=SEXES[species.sex], fertility=species.fertility)
    table.traits |= {"species": species, "emits": dict(species.emits), "diet": list(species.diet), "lethal": list(species.lethal),
                     "reproduction": species.reproduction, "remains": species.remains, "sex": species.sex, "max_count": species.max_count}
    if species.sensors or actions:
        table.add_component(Nervous)
        dims = world.config.dims
        table.traits["nerves"] = Nerves(species.channels(dims), senses_of(species, dims, world.substances), species.actions,
                                        species.neutral, species.automatic, species.readings(dims))
    if species.locomotion is not None and "nerves" in table.traits:
        table.add_component(Velocity)
        table.traits["gaits"] = _gaits(species.locomotion, table.traits["nerves"])


def _gaits(way: Any, nerves: Nerves) -> tuple[np.ndarray, ...]:
    """Return layout i64[3, 3] and the speeds, costs, turns and climbs of the actions that move a body."""
    layout = np.zeros((3, 3), np.int64)
    values = []
    for i, group in enumerate(("speed", "turn", "climb")):
        names = nerves.groups.get(group, [])
        if names:
            layout[i] = (*nerves.columns[group], nerves.neutral[group])
        values.append(names)
    speeds, turns, climbs = values
    turning = {"left": way.turn, "right": -way.turn}
    climbing = {"up": way.climb, "down": -way.climb}
    arrays = ([way.speed.get(a, 0.0) for a in speeds], [way.cost.get(a, 0.0) for a in speeds],
              [turning.get(a, 0.0) for a in turns], [climbing.get(a, 0.0) for a in climbs])
    return layout, *(np.array(a or [0.0], np.float32) for a in arrays)


def _networks(world: Any, table: Any, species: Any, policies: Any, learn: Any, number: int,
              training: bool) -> np.ndarray | None:
    """Build the reflex, happiness and policy networks of one species; return the weights that founders have alike, if any."""
    nerves = table.traits.get("nerves")
    if nerves is None:
        return None
    coded = {gene.trait.partition(".")[0] for gene in (species.genome.genes if species.genome else ()) if gene.trait}
    if species.reflex is not None:
        nerves.reflex = ReflexNetwork(species.reflex, nerves, species.action_rows(), "reflex" in coded)
    if species.happiness is not None:
        nerves.happiness = HappinessNetwork(species.happiness, nerves, "happiness" in coded)
        nerves.minimum = np.float32(species.happiness.minimum)
    if species.policy.kind == "none" or not nerves.choices:
        return None
    nerves.policy = True
    source = policies.get(table.name, "trained") if isinstance(policies, dict) else policies
    if source == "random":
        return None
    from ecs_eco.learning import PPO, Brain, Learner
    from ecs_eco.learning.individual import Individuals

    seed = (random.mix_int(world.seed) + number) & 0x7FFFFFFFFFFFFFFF
    alone = species.policy.kind == "individual" and not training  # a policy is pre-trained by all, for all
    shape = len(nerves.channels), nerves.choices, tuple(species.policy.hidden)
    path = _weights_file(world, species, table.name, source)
    brain = None if alone and path is None else Brain(*shape, seed=seed)
    if path is not None and brain is not None:
        _load(brain, path, table.name)
    chosen = learn.get(table.name) if isinstance(learn, Mapping) else learn
    nerves.learning = species.policy.learn if chosen is None else chosen
    if nerves.learning and nerves.happiness is None:
        raise ConfigError([Problem(("species", table.name, "policy", "learn"), "nothing rewards it", True,
                                   "a species that learns declares `happiness`; or learn = false")])
    ppo = PPO(**species.ppo)
    if not training:
        ppo = replace(ppo, anneal=0)  # a plan for pre-training: life has no end to plan for
    if alone:
        nerves.individuals = Individuals(*shape, ppo, seed)
        return None if brain is None else flat(nerves.individuals, brain)
    assert brain is not None
    nerves.brain = brain
    if nerves.learning:
        nerves.learner = Learner(brain, ppo, seed=seed, workers=world.threads)
    return None


def _load(brain: Any, path: Path, name: str) -> None:
    """Load trained weights, or say what is wrong with the file."""
    from safetensors import SafetensorError
    from safetensors.numpy import load_file

    try:
        brain.load(load_file(path))
    except (ValueError, SafetensorError) as error:
        raise ConfigError([Problem(("species", name, "policy"), str(error), str(path), "weights of this species' network")]) from None


def _weights_file(world: Any, species: Any, name: str, source: Any) -> Path | None:
    if source == "trained":
        return world.config.file(species.policy.file) if species.policy.file else None
    if source == "untrained":
        return None
    folder = Path(source)
    if not folder.is_dir():
        allowed = f"{listed(POLICIES)}, or a folder of <species>.safetensors"
        raise ConfigError([Problem((), "unknown source of policies", str(source), allowed, nearest(source, POLICIES), "policies")])
    path = folder / f"{name}.safetensors"
    if not path.is_file():
        needed = "<species>.safetensors for every species with a policy"
        raise ConfigError([Problem((), "missing", str(path), needed, source="policies")])
    return path


def _populate(world: Any, table: Any, kind: Any) -> None:
    """Ask for the first generation: at the places named, the rest at random."""
    if len(getattr(kind, "at", ())):
        place = np.array([[*at, 0.0][:3] for at in kind.at], np.float32)
        none = np.zeros(len(place), np.uint64)
        table.request(none, {(Position, axis): place[:, i] for i, axis in enumerate("xyz")})
    if kind.count:
        who = np.arange(1, kind.count + 1, dtype=np.uint64)
        values = scatter(table, world, who)
        way = getattr(kind, "reproduction", None)
        if way is not None and way.kind == "spread":
            _one_a_site(world, table, way.spacing, values)
        count = values[Position, "x"].size
        if Metabolism in table and "nerves" in table.traits:  # of all stages between hungry and newborn, so that they do not die as one
            u = random.draw_many(world.key, who[:count], random.BIRTH + ((table.place + 1) << 20))
            values[Metabolism, "energy"] = (np.float32(kind.metabolism.energy) * (np.float32(0.75) + np.float32(0.5) * u)).clip(
                0, kind.metabolism.energy_max).astype(np.float32)
        if (heredity := table.traits.get("heredity")) is not None:
            values |= heredity.founders(world, table, who[:count])
        table.request(np.zeros(count, np.uint64), values)


def _one_a_site(world: Any, table: Any, spacing: float, values: dict) -> None:
    """Move the first plants to sites of their own, drawn without replacement."""
    nx, ny = (max(1, round(s / spacing)) for s in world.space.size[:2])
    k = min(values[Position, "x"].size, nx * ny)
    key, salt = world.key, (table.place + 1) << 20  # not the draws of Spread in the first tick, nor those of another species
    order = np.argsort(random.draw_many(key, np.arange(nx * ny, dtype=np.uint64), random.SPREAD + salt), kind="stable")
    if world.terrain is not None:
        x, y = ((order % nx) + 0.5) * world.space.size[0] / nx, ((order // nx) + 0.5) * world.space.size[1] / ny
        order = order[world.terrain.free(x, y)]
    site = np.sort(order[:k])
    who = site.astype(np.uint64)
    u, v = random.draw_many(key, who, random.PLACE + salt), random.draw_many(key, who, random.PLACE + (1 << 8) + salt)
    near = np.nextafter(world.space.lengths, np.float32(0))
    for axis, cells, fraction, n, i in (("x", site % nx, u, nx, 0), ("y", site // nx, v, ny, 1)):
        values[Position, axis] = np.minimum((cells + fraction) * np.float32(world.space.size[i] / n), near[i]).astype(np.float32)
    for name in ("z", "heading"):
        values[Position, name] = values[Position, name][: site.size]
    for key in [k for k in values if k[0] is Biology]:
        values[key] = values[key][: site.size]
