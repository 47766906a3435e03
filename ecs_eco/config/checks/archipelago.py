"""Checks of an archipelago: its graph, and who emigrates. Values of islands are checked once the world is."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import Problem, listed, nearest


def check_archipelago(config: WorldConfig) -> Iterator[Problem]:
    """The problems of [archipelago]."""
    plan = config.archipelago
    if plan is None:
        return
    at, names = ("archipelago",), plan.names
    if plan.here is not None and plan.here not in names:
        yield Problem((*at, "here"), "no such island", plan.here, listed(names), nearest(plan.here, names))
    for name in plan.emigration:
        if name not in config.species:
            yield Problem(
                (*at, "emigration", name),
                "no such species",
                name,
                listed(config.species),
                nearest(name, config.species),
            )
        elif getattr(config.species[name].reproduction, "kind", None) == "spread":
            yield Problem(
                (*at, "emigration", name),
                "keeps its site: plants that spread do not wander",
                name,
                "a species that has no reproduction of the kind spread",
            )
    if plan.graph != "own" and plan.edges:
        yield Problem(
            (*at, "edges"),
            f"the graph {plan.graph} has edges of its own",
            len(plan.edges),
            'graph = "own", or no edges',
        )
    if plan.graph == "own" and not plan.edges:
        yield Problem((*at, "edges"), "is missing", allowed='a list of [from, to], or graph = "ring"')
    for i, edge in enumerate(plan.edges):
        for j, name in enumerate(edge):
            if name not in names:
                yield Problem(
                    (*at, "edges", i, j), "no such island", name, listed(names), nearest(name, names)
                )
        if edge[0] == edge[1]:
            yield Problem((*at, "edges", i), "leads from an island to itself", edge, "two islands")
        elif edge in plan.edges[:i]:
            yield Problem((*at, "edges", i), "stands there already", edge, "each edge once")
