"""Treatments that are applied as a world is built: something is removed, to measure what it contributes.

Their names are what `controls=` of a world and "controls" in manifests and checkpoints list;
`ecs_eco.lab.treatments` has these and all others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest
from ecs_eco.genomes.heredity import Heredity
from ecs_eco.life.kind import Kind

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld


def no_reflexes(species: Iterable[Kind]) -> None:
    """No organism has a reflex, whether its species' or its genes'."""
    for kind in species:
        if kind.nerves is not None:
            kind.nerves.reflex = None


def neutral_drift(species: Iterable[Kind]) -> None:
    """Genes are inherited, cross and mutate, but not expressed: all have the values of their species."""
    for heredity in _heredities(species):
        if heredity.layout is not None:
            heredity.expression = False


def shuffled_genome(species: Iterable[Kind]) -> None:
    """Genes and inherited weights of a newborn come from any of the living instead of its parents.

    Genes that keep their owner alive are still more common among the living;
    those that make it breed more are not passed on.
    """
    for heredity in _heredities(species):
        heredity.shuffled = True


def no_mutation(species: Iterable[Kind]) -> None:
    """Genomes cross and never mutate, and inherited weights get no noise: lost alleles do not come back."""
    for heredity in _heredities(species):
        heredity.mutation = False


TREATMENTS: dict[str, Callable[[Iterable[Kind]], None]] = {
    "no-reflexes": no_reflexes,
    "neutral-drift": neutral_drift,
    "shuffled-genome": shuffled_genome,
    "no-mutation": no_mutation,
}


def apply(names: Sequence[str], world: SpatialWorld) -> None:
    """Apply treatments to a world that is being built. Raises ConfigError for an unknown name."""
    for name in names:
        if name not in TREATMENTS:
            near = nearest(name, TREATMENTS)
            raise ConfigError([Problem((), "no such treatment", name, listed(TREATMENTS), near, "controls")])
        TREATMENTS[name]([table.species for table in world.tables.values()])


def _heredities(species: Iterable[Kind]) -> list[Heredity]:
    return [kind.heredity for kind in species if kind.heredity is not None]
