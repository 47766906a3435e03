"""The worlds of an archipelago: checks of [archipelago] and of islands' values, and islands' seeds."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from ecs_eco.config.explain import value_at
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.ranges import key_of
from ecs_eco.config.rules import no_such, written_at
from ecs_eco.engine.errors import ConfigError, Problem

FIXED = ("archipelago", "code", "dt", "format", "name", "ticks")
"""Parts of a world that all islands share."""
ALIKE: tuple[tuple[str, ...], ...] = (
    ("genome",),
    ("sensors",),
    ("actions",),
    ("components",),
    ("policy", "kind"),
    ("policy", "hidden"),
    ("policy", "network"),
    ("ppo", "horizon"),
)
"""Parts of a migrating species that must be the same on all islands, because they define its columns."""


def seed_of(seed: int, number: int) -> int:
    """Return the seed (less than 2^53) of the island with this number; `seed` is the archipelago's seed."""
    from ecs_eco.engine.random import mix_int  # it loads numba

    return mix_int(mix_int(seed) + number) >> 11


def check_islands(config: WorldConfig, world_of: Callable[[WorldConfig, str], WorldConfig]) -> list[Problem]:
    """Return problems with the values that islands set; `world_of` returns an island's world by its name."""
    plan = config.archipelago
    if plan is None or plan.here is not None:
        return []
    problems: list[Problem] = []
    worlds: dict[str, WorldConfig] = {}
    for name, own in plan.islands.items():
        place = ("archipelago", "islands", name)
        problems += [
            Problem(
                (*place, key),
                "must be the same on all islands",
                value,
                "a different key, such as species.deer.count",
            )
            for key, value in own.items()
            if key_of(key)[0] in FIXED
        ]
        if not problems:
            try:
                worlds[name] = world_of(config, name) if own or not worlds else config
            except ConfigError as error:
                problems += [written_at(p, place, _written(p, own)) for p in error.problems]
    return problems or [p for name, world in worlds.items() for p in _unlike(config, world, name)]


def _written(problem: Problem, values: Iterable[str]) -> str | None:
    """Return the dotted key in `values` that caused a problem, if any."""
    path = ".".join(map(str, problem.key))
    return next((key for key in values if key == path or path.startswith(f"{key}.")), None)


def _unlike(config: WorldConfig, world: WorldConfig, name: str) -> Iterator[Problem]:
    """Yield the differences that prevent an island from exchanging migrants."""
    place = ("archipelago", "islands", name)
    pairs: list[tuple[str, Any, Any]] = [
        ("substances", list(config.substances), list(world.substances)),
        ("space.size", config.dims, world.dims),
    ]
    for species in config.archipelago.migration_probability if config.archipelago is not None else ():
        one, other = (w.species[species].model_dump(mode="json") for w in (config, world))
        pairs += [
            (f"species.{species}.{'.'.join(path)}", value_at(one, path), value_at(other, path))
            for path in ALIKE
        ]
        pairs += [
            (f"species.{species}.{part}", list(one[part]), list(other[part]))
            for part in ("properties", "substances")
        ]
    for key, before, now in pairs:
        if before != now:
            fault = "differs from the other islands, but migrants take it with them"
            allowed = "the same on all islands, or a species that does not migrate"
            yield Problem((*place, key), fault, allowed=allowed)


def check_archipelago(config: WorldConfig) -> Iterator[Problem]:
    """Yield the problems with [archipelago]."""
    plan = config.archipelago
    if plan is None:
        return
    at, names = ("archipelago",), plan.names
    if plan.here is not None and plan.here not in names:
        yield no_such((*at, "here"), "island", plan.here, names)
    for name in plan.migration_probability:
        if name not in config.species:
            yield no_such((*at, "migration_probability", name), "species", name, config.species)
        elif getattr(config.species[name].reproduction, "kind", None) == "spread":
            fault = "cannot migrate: plants that spread keep their sites"
            allowed = "a species with another kind of reproduction"
            yield Problem((*at, "migration_probability", name), fault, name, allowed)
    if plan.graph != "own" and plan.edges:
        fault = f"the graph {plan.graph} defines its edges"
        yield Problem((*at, "edges"), fault, len(plan.edges), 'graph = "own", or remove edges')
    if plan.graph == "own" and not plan.edges:
        yield Problem((*at, "edges"), "is missing", allowed='a list of [from, to], or graph = "ring"')
    for i, edge in enumerate(plan.edges):
        for j, name in enumerate(edge):
            if name not in names:
                yield no_such((*at, "edges", i, j), "island", name, names)
        if edge[0] == edge[1]:
            yield Problem((*at, "edges", i), "leads from an island to itself", edge, "two islands")
        elif edge in plan.edges[:i]:
            yield Problem((*at, "edges", i), "is already listed", edge, "each edge once")
