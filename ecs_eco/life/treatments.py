"""Treatments applied when a world is built; each removes a factor to measure its contribution.

Their names are listed in a world's `controls=` and under "controls" in manifests and checkpoints;
`ecs_eco.lab.treatments` contains these and all other treatments.
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
    """Remove all reflexes, whether declared by the species or coded by genes."""
    for kind in species:
        if kind.nerves is not None:
            kind.nerves.reflex = None


def neutral_drift(species: Iterable[Kind]) -> None:
    """Switch off the expression of genes, which are still inherited, crossed and mutated, so that all
    organisms have the values of their species."""
    for heredity in _heredities(species):
        if heredity.layout is not None:
            heredity.expression = False


def shuffled_genome(species: Iterable[Kind]) -> None:
    """Give a newborn the genes and inherited weights of random living members instead of its parents.

    Genes that keep their carriers alive still become more common; genes that make their carriers breed more
    have no advantage.
    """
    for heredity in _heredities(species):
        heredity.shuffled = True


def no_mutation(species: Iterable[Kind]) -> None:
    """Switch off mutation of genomes and noise in inherited weights: lost alleles do not come back."""
    for heredity in _heredities(species):
        heredity.mutation = False


TREATMENTS: dict[str, Callable[[Iterable[Kind]], None]] = {
    "no-reflexes": no_reflexes,
    "neutral-drift": neutral_drift,
    "shuffled-genome": shuffled_genome,
    "no-mutation": no_mutation,
}


def apply(names: Sequence[str], world: SpatialWorld) -> None:
    """Apply treatments to a world that is being built. Raises a ConfigError for an unknown name."""
    for name in names:
        if name not in TREATMENTS:
            near = nearest(name, TREATMENTS)
            raise ConfigError([Problem((), "no such treatment", name, listed(TREATMENTS), near, "controls")])
        TREATMENTS[name]([table.species for table in world.tables.values()])


def _heredities(species: Iterable[Kind]) -> list[Heredity]:
    return [kind.heredity for kind in species if kind.heredity is not None]
