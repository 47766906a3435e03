"""Controls: a world from which one thing is taken away, so that its part in what happens can be told."""

from collections.abc import Callable, Sequence
from typing import Any

from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest


def no_reflexes(world: Any) -> None:
    """No organism has a reflex, whether its species' or its genes'."""
    for nerves in _all(world, "nerves"):
        nerves.reflex = None


def neutral_drift(world: Any) -> None:
    """Genes are inherited, cross and mutate, and say nothing: all organisms are born with the values of their species."""
    for heredity in _genomes(world):
        heredity.expression = False


def shuffled_genome(world: Any) -> None:
    """Genes speak, but a newborn's come, as inherited weights do, from any of the living instead of its parents.

    What keeps its owner alive is still more common among the living; what makes it breed more is not passed on.
    """
    for heredity in _all(world, "heredity"):
        heredity.shuffled = True


def no_mutation(world: Any) -> None:
    """Genomes cross and never mutate, and inherited weights get no noise: what is lost does not come back."""
    for heredity in _all(world, "heredity"):
        heredity.mutation = False


CONTROLS: dict[str, Callable[[Any], None]] = {
    "no-reflexes": no_reflexes, "neutral-drift": neutral_drift, "shuffled-genome": shuffled_genome, "no-mutation": no_mutation,
}  # fmt: skip


def apply(names: Sequence[str], world: Any) -> None:
    """Apply controls to a world that is being built; raises ConfigError for a name that is none."""
    for name in names:
        if name not in CONTROLS:
            raise ConfigError([Problem((), "no such control", name, listed(CONTROLS), nearest(name, CONTROLS), "controls")])
        CONTROLS[name](world)


def _all(world: Any, trait: str) -> list[Any]:
    return [part for t in world.tables.values() if (part := getattr(t.species, trait)) is not None]


def _genomes(world: Any) -> list[Any]:
    return [h for h in _all(world, "heredity") if h.layout is not None]
