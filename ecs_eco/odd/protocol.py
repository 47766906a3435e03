"""The description of a world: the seven elements of the ODD protocol, in order.

Grimm, V. et al. (2020). The ODD protocol for describing agent-based and other simulation models: a second update
to improve clarity, replication, and structural realism. JASSS 23(2) 7.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import takewhile

from ecs_eco.components import Biology, Metabolism, Physical
from ecs_eco.config.loading import WorldSource, island_of, load
from ecs_eco.config.models.interventions import Intervention, describe as in_words
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.ecosystem import World
from ecs_eco.engine.comments import comments_of
from ecs_eco.engine.files import read_bytes
from ecs_eco.life.founders import energy_spread
from ecs_eco.odd.concepts import concepts
from ecs_eco.odd.document import Block, Document, Heading, Items, grid
from ecs_eco.odd.model import Model
from ecs_eco.odd.submodels import parameters, submodels
from ecs_eco.odd.values import first_sentence, keys_given, lists_of, shown, values_of

OTHERWISE = ("count", "age", "max_count", "at", "between", "heading", "color", "components", "policy", "ppo")
"""Keys of kinds that element 5 describes or that have no biological meaning."""
STARTS = ("count", "max_count", "age", "at", "between", "heading", "sex")
SURROUNDINGS = ("substances", "terrain", "ambient", "sun", "year", "water")
OPTIONAL = (Biology, Metabolism, Physical)  # components of which a world may use only some fields or none
UPRIGHT = ("z", "climb")  # fields that are 0 on a plane
REFERENCE = (
    "This description follows the ODD protocol (Overview, Design concepts, Details; Grimm et al. 2020, JASSS 23(2) "
    "7). `ecs-eco describe` generated it from the world file and the program's declarations."
)


def describe(world: World | WorldSource, *, trust: bool = False) -> Document:
    """Return the ODD description of a world.

    Parameters
    ----------
    world : World, str, Path, Mapping or WorldConfig
        A live world, or anything that `World.from_config` accepts.
    trust : bool, default False
        Whether code named in the world file is allowed to run.

    Returns
    -------
    Document
        The seven elements of the protocol (Grimm et al. 2020, JASSS 23(2) 7); `markdown()` and `html()`
        return it as text.

    Raises
    ------
    ConfigError
        If the world is not valid.

    Examples
    --------
    >>> from ecs_eco.odd import describe
    >>> describe("reflexes").markdown().splitlines()[0]
    '# Goats, three grasses, and the genes for not eating them: ODD description'
    """
    if not isinstance(world, World):
        world = _built(world if isinstance(world, WorldConfig) and not trust else load(world, trust=trust))
    model = Model(world)
    elements = (
        ("Purpose and patterns", purpose),
        ("Entities, state variables and scales", entities),
        ("Process overview and scheduling", schedule),
        ("Design concepts", concepts),
        ("Initialization", initialization),
        ("Input data", inputs),
        ("Submodels", submodels),
    )
    config = model.config
    title = model.world.name if config is None else config.title or config.name
    document = Document([Heading(1, f"{title}: ODD description"), REFERENCE])
    for number, (name, element) in enumerate(elements, 1):
        document += [Heading(2, f"{number}. {name}"), *element(model)]
    return document


def _built(config: WorldConfig) -> World:
    """Build a world without organisms; for an archipelago, its first island."""
    islands = config.archipelago
    here = config if islands is None or islands.here else island_of(config, islands.names[0])
    world = World.from_config(here, populate=False, record=False)
    world.config = config
    return world


def purpose(model: Model) -> Iterator[Block]:
    """Yield element 1."""
    config = model.config
    if config is None:
        yield f"The `{model.world.name}` world is built in Python; the program states no purpose."
        return
    none = f"The world file states no purpose; its title is: {config.title}."
    yield config.description or _told(config) or none
    if config.patterns:
        yield "The model is evaluated by these patterns:"
        yield Items(tuple(config.patterns))
    else:
        yield "The world file lists no patterns (key `patterns`)."
    if config.data is not None:
        yield f"It is compared with the measurements in `{config.data.file}`: {shown(config.data.statistics)}."


def _told(config: WorldConfig) -> str:
    """Return the first paragraph of a world's README or, failing that, the comment at the top of its file."""
    file = config.folder / config._source
    if not file.is_file():
        return ""
    readme = file.with_name("README.md")
    alone = [*config.folder.glob("*.toml")] == [file]  # otherwise the README describes more than this world
    if readme.is_file() and alone:
        parts = re.split(r"\n\s*\n", read_bytes(readme).decode("utf-8", "replace"))
        text = next((part for part in parts if part.strip() and not part.startswith("#")), "")
        return " ".join(re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text).replace("**", "").split())
    lines = takewhile(
        lambda line: line.startswith("#"), read_bytes(file).decode("utf-8-sig", "replace").splitlines()
    )
    return " ".join(line.lstrip("# ") for line in lines if not line.startswith("#  "))  # skip commands


def entities(model: Model) -> Iterator[Block]:
    """Yield element 2."""
    yield Heading(3, "Entities")
    known = dict.fromkeys(model.sections, "type of object") | dict.fromkeys(model.organisms, "species")
    yield from grid(("kind", "entity"), [(n, known.get(n, "landmark or other object")) for n in model.tables])
    yield (
        "Each individual has a unique number (uid). Space, with its fields and surroundings, is another entity. "
        "So is each policy network that the members of a species share; its state is its weights."
    )
    yield Heading(3, "State variables")
    yield from grid(("variable", "unit", "meaning", "kinds", "static or dynamic"), _state(model))
    constants = [
        (kind, key)
        for kind, section in model.sections.items()
        for key in section.model_fields_set
        if key not in model.claimed(kind) and key not in OTHERWISE
    ]
    if blocks := [*parameters(model, constants)]:
        yield Heading(3, "Constants of kinds")
        yield "Other constants are in element 7; – means absent, or listed there."
        yield from blocks
    yield from _scales(model)


def _state(model: Model) -> Iterator[tuple[str, ...]]:
    """Yield a row (names, unit, meaning, kinds, changes) for each group of similar state variables."""
    rows: dict[tuple[str, ...], list[str]] = {}
    given = {key.rpartition(".")[2] for section in model.sections.values() for key in keys_given(section)}
    components = {c.__name__: c for table in model.tables.values() for c in table if c not in table.derived}
    for name, component in sorted(components.items()):
        having = [kind for kind, table in model.tables.items() if component in table]
        known = comments_of(component)
        for field in component.fields:  # type: ignore[attr-defined]
            if field in UPRIGHT and not model.world.space.volume:
                continue
            changed = any(model.changes(kind, name, field, titled=True) for kind in having)
            if component in OPTIONAL and not changed and field not in given:
                continue
            unit, text = known.get(field, ("", ""))
            dynamic = [kind for kind in having if model.changes(kind, name, field)]
            change = f"dynamic: {', '.join(dynamic)}" if dynamic else "static"
            change = "dynamic" if dynamic == having else change
            row = (name, unit, text or first_sentence(component), _kinds(model, having), change)
            rows.setdefault(row, []).append(f"`{name}.{field}`")
    for (_, *cells), names in rows.items():
        yield ", ".join(names), *cells


def _kinds(model: Model, kinds: Sequence[str]) -> str:
    return "all" if len(kinds) == len(model.tables) > 1 else ", ".join(kinds)


def _scales(model: Model) -> Iterator[Block]:
    """Yield the extent and resolution of space and time, and the state of the surroundings."""
    world, config = model.world, model.config
    space = world.space
    yield Heading(3, "Scales")
    edges = "wrap around (torus)" if space.torus else "are walls"
    rows = [
        ("extent", " × ".join(shown(size) for size in space.size) + " m"),
        ("edges", f"{edges}{'; surface and bottom are walls' * (space.volume and space.torus)}"),
        ("positions", "continuous"),
        ("time step", f"{shown(world.dt)} s"),
    ]
    if config is not None:
        span = f"{config.ticks:,} ticks = {shown(config.ticks * config.dt)} s"
        rows.append(("length of a run", span))
        for name, field in config.fields.items():
            held = (
                f"concentration of {field.substance} [mol/L]" if field.substance else "a smell, not an amount"
            )
            rows.append((f"field `{name}`", f"cells of {shown(field.cell)} m; {held}; dynamic"))
        if config.terrain is not None:
            rows.append(("terrain", f"cells of {shown(config.terrain.cell)} m; static"))
    yield from grid(("scale", "value"), rows)
    if config is not None:
        rest = config.model_fields_set - model.claimed("")
        yield from parameters(model, [("", key) for key in SURROUNDINGS if key in rest])


def schedule(model: Model) -> Iterator[Block]:
    """Yield element 3."""
    yield (
        f"Time advances in ticks of {shown(model.world.dt)} s. In each tick, the processes below act one after "
        "another, each on all its entities before the next begins. Deaths take effect at the end of the phase "
        "`die`, births at the end of the `reproduce` phase."
    )
    rows = []
    for number, (system, kinds) in enumerate(model.active.items(), 1):
        keys = {key.partition(".")[0] for key in getattr(system.submodel, "where", ())}
        whole = (not keys or keys & WorldConfig.model_fields.keys()) and not (
            system.needs or system.asked_for
        )
        of = "the world" if whole else _kinds(model, kinds)
        present = {component.__name__ for kind in kinds for component in model.tables[kind]}
        changed = [change.rpartition(": ")[2] for change in model.changed_by(system)]
        changes = ", ".join(f"`{change}`" for change in changed if change.partition(".")[0] in present)
        if system.submodel is None:
            changes = "not declared"
        what = first_sentence(type(system)) or "Its class has no docstring."
        rows.append((f"{number}", system.phase, f"`{type(system).__name__}`", of, what, changes))
    yield from grid(("", "phase", "process", "entities", "what happens", "changes"), rows)
    if idle := [type(system).__name__ for system in model.systems if system not in model.active]:
        names = ", ".join(f"`{name}`" for name in idle)
        yield f"Other systems in the schedule have no effect in this world: {names}."
    yield (
        "Competition within a process is resolved by distance or at random; results do not depend on the order in "
        "which individuals are stored."
    )


def initialization(model: Model) -> Iterator[Block]:
    """Yield element 5."""
    config = model.config
    if config is None:
        yield f"The program creates the first entities. The random seed is {model.world.seed}."
        yield from grid(("kind", "entities now"), [(n, f"{t.n:,}") for n, t in model.tables.items()])
        return
    yield (
        "Founders have random positions and headings and age 0, unless these are given. The values in "
        "elements 2 and 7 also apply to founders."
    )
    yield from parameters(model, [(kind, key) for kind in model.sections for key in STARTS])
    rows = [(name, *_policy(model, name)) for name in model.organisms if _policy(model, name)[0]]
    yield from grid(("species", "policy", "initial policy"), rows)
    yield from _first_energy(model)
    fields = [(n, f"{shown(f.initial)} mol/L") for n, f in config.fields.items() if f.initial is not None]
    yield from grid(("field", "initial concentration"), fields)
    yield f"The default random seed is {config.seed}; each seed yields a different run of the same world."


def _policy(model: Model, name: str) -> tuple[str, str]:
    """Return the kind of a species' policy and the source of its initial weights; "" if there is no policy."""
    policy = model.config.species[name].policy if model.config is not None else None
    if policy is None or policy.kind == "none":
        return "", ""
    if not policy.thinks:
        return policy.kind, "decisions come from a function or a program"
    untrained = {"birth": "weights in the genome"}.get(policy.inherit, "random weights")
    return policy.kind, f"trained weights, `{policy.file}`" if policy.file else untrained


def _first_energy(model: Model) -> Iterator[Block]:
    """Yield the initial energies of founders, which vary for species with a nervous system."""
    rows = []
    for name, section in model.sections.items():
        if isinstance(section, Species) and "metabolism" in section.model_fields_set:
            share = energy_spread(model.world.tables[name], section)
            uniform = f"{shown(1 - share)} to {shown(1 + share)} times that, uniform"
            spread = uniform if share else "the same for all"
            rows.append((name, shown(section.metabolism.energy), spread))
    yield from grid(("species", "energy of founders", "variation"), rows)


def inputs(model: Model) -> Iterator[Block]:
    """Yield element 6."""
    config, rows = model.config, list[str]()
    if config is not None and config.terrain is not None:
        files = [value for value in values_of(config.terrain) if value.key in ("raster", "cover")]
        rows += [f"`{value.value}`: {value.text}" for value in files]
        layers = dict(lists_of(config.terrain)).get("layers", [])
        rows += [f"`{getattr(layer, 'file', '')}`: {getattr(layer, 'make', '')}" for _, layer in layers]
    if config is not None:
        rows += [
            f"At tick {one.at:,}{_again(one)}: {in_words(one.once(one.at))}." for one in config.interventions
        ]
    if not rows:
        yield "The model uses no input data to represent processes that change over time."
        return
    yield "The model takes these external inputs:"
    yield Items(tuple(rows))


def _again(one: Intervention) -> str:
    until = f" until tick {one.until:,}" if one.until else ""
    return "" if one.every is None else f", then every {one.every:,} ticks{until}"
