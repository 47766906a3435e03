"""Build a species' heredity from its genome section: layout, operators, and the columns that its genes write."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco import components as own
from ecs_eco.components import Experience, Genome, Gestation, Instincts, Memory, Policy
from ecs_eco.config.derived import all_genes, formulas_of
from ecs_eco.config.shapes import instincts, shapes_of_networks
from ecs_eco.config.traits import traits_of
from ecs_eco.engine.errors import ConfigError, Problem
from ecs_eco.genomes.heredity import Heredity
from ecs_eco.genomes.variable_layout import layout_of

if TYPE_CHECKING:
    from ecs_eco.config.models.species import Species
    from ecs_eco.engine.table import Table
    from ecs_eco.genomes.traits import Trait
    from ecs_eco.space.world import SpatialWorld

Targets = dict[str, tuple[type, str, int | None]]
# components whose defaults are set together with the species' bodies and brains
OF_NEWBORN = ("Policy", "Body", "Biology", "Physical", "Chemistry")


def add_heredity(
    world: SpatialWorld, table: Table, species: Species, founder: np.ndarray | None = None
) -> None:
    """Give a table its genome, the columns that its genes write, and the columns of individual brains, as
    needed."""
    for name in species.components:
        table.add_component(world.config.function(name))
    nerves, section = table.species.nerves, species.genome
    minds = None if nerves is None else nerves.individuals
    if minds is not None:
        table.dims |= minds.dims
        table.add_component(Policy)
        if minds.memory:
            table.add_component(Memory)
        if nerves.learning:
            table.add_component(Experience)
    layout, targets, alike, derived = None, {}, None, {}
    if section is not None:
        traits = _traits(world, species)
        shapes = shapes_of_networks(world.config, table.name)
        if minds is not None:
            shapes["policy.weights"] = minds.shapes
        layout = layout_of(section, traits, shapes)
        highest = len(layout.alphabet) - (1 if layout.longest is None else 0)  # the blank follows the letters
        table.dims |= {"loci": layout.row, "highest letter": highest}
        table.add_component(Genome)
        networks = {trait: network.weights for trait, network in instincts(world.config, table.name).items()}
        targets = _targets(table, species, traits, networks)
        formulas, _ = formulas_of(section)
        derived = {
            name: (formula, traits[str(section.derived[name].trait)]) for name, formula in formulas.items()
        }
        if section.founders == "own":
            alike = _alike(
                layout, networks if founder is None else networks | {"policy.weights": founder}, table.name
            )
    if species.reproduction is not None and species.reproduction.kind == "sexual":
        table.dims.setdefault("loci", 0)
        table.add_component(Gestation)
    if section is not None or minds is not None:
        table.species.heredity = Heredity(
            layout, None, targets, minds=minds, founder=founder, alike=alike, derived=derived
        )


def _alike(layout: Any, networks: Mapping[str, np.ndarray], name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the letters u8[loci] that code for the species' values, and which of them all founders share,
    bool[loci]; `networks` contains weights f32[size] by trait, for example from a file."""
    row, shared = layout.own(), layout.coded()
    for i, code in enumerate(layout.genes):
        if code.trait is None or code.trait.name not in networks:
            continue
        try:
            numbers = code.numbers(networks[code.trait.name][None].astype(np.float64), clip=False)
        except ValueError as error:
            key = ("species", name, "genome", "genes", i)
            fault = f"it cannot code for the weights of founders: {error}"
            allowed = 'a wider range, or founders = "random"'
            raise ConfigError([Problem(key, fault, code.name, allowed)]) from None
        for first in layout.begins(code):
            code.codons.write(numbers, row, first - code.codons.first)
            shared[first : first + code.codons.length] = True
    return row[0], shared


def apply_heredity(
    world: SpatialWorld,
    table: Table,
    species: Species,
    changed: Collection[str] | None = None,
    before: Species | None = None,
) -> None:
    """Set how brains are inherited, the individual traits that no gene codes for, and the operators that
    create genomes.

    Rebuilds operators if `changed` is None or contains one of their dotted keys in the species' section. For
    a species in a live world, whose section was `before`, only traits that differ are set.
    """
    heredity = table.species.heredity
    if heredity is None:
        return
    heredity.inherit, heredity.noise = species.policy.inherit, float(species.policy.mutation_sd)
    if species.genome is None:
        return
    now, former = _traits(world, species), None if before is None else _traits(world, before)
    apply_traits(table, now, former)
    if changed is None or any(key.startswith(("genome.", "reproduction.choice")) for key in changed):
        from ecs_eco.genomes import operators_of

        choice, counts = getattr(species.reproduction, "choice", "nearest"), heredity.state()
        heredity.operators = operators_of(
            species.genome, heredity.layout, choice, world.config.function, species.mates
        )
        heredity.load(counts)


def _traits(world: SpatialWorld, species: Species) -> dict[str, Trait]:
    return traits_of(species, world.config.dims, world.config.own_components(species))


def apply_traits(
    table: Table, traits: Mapping[str, Trait], before: Mapping[str, Trait] | None = None
) -> None:
    """Set the columns of newborns' individual traits, unless a gene codes for them.

    For a table in a live world, whose traits were `before`, those that differ are also set for living
    organisms.
    """
    written = {component.__name__ for component, _, _ in table.species.heredity.targets.values()}
    columns = {
        component.__name__: component
        for component in table.columns
        if before is not None or component.__name__ in written
    }
    for name, trait in traits.items():
        if trait.component not in columns or trait.component in OF_NEWBORN:
            continue
        if (trait.component == "Traits" and trait.index is None) or trait.component == "Instincts":
            continue  # shared by all, or a whole network
        if before is not None and (name not in before or before[name].default == trait.default):
            continue
        component, at = columns[trait.component], ... if trait.index is None else trait.index
        table.defaults[component][trait.field][at] = trait.default
        if before is not None:
            column = table.field(component, trait.field)
            column[(table.rows(), *(() if trait.index is None else (trait.index,)))] = trait.default


def _targets(
    table: Table, species: Species, traits: dict[str, Any], networks: Mapping[str, np.ndarray]
) -> Targets:
    """Add the components to which genes write, with the species' values as defaults; return where each gene
    writes."""
    coded = [
        (gene, traits[gene.trait])
        for gene in all_genes(species)
        if gene.trait is not None and (gene.trait != "policy.weights" or Policy in table)
    ]
    used = {trait.component for _, trait in coded}
    known = {c.__name__: c for c in (*table.columns, *(getattr(own, n) for n in own.__all__))}
    table.dims |= {
        "sensors": len(species.sensors),
        "connections": len(species.reflex.connections if species.reflex else ()),
        "desires": len(species.happiness.weights if species.happiness else ()),
    }
    table.species.traits = {
        t.name: t.index for t in traits.values() if t.component == "Traits" and t.index is not None
    }
    table.dims["traits"] = len(table.species.traits)
    for word in ("reflex", "happiness"):
        table.dims[f"{word}_weights"] = len(networks.get(f"{word}.weights", ()))
    for trait in traits.values():
        if trait.component in used and trait.component not in OF_NEWBORN:
            component = known[trait.component]
            if component not in table:
                table.add_component(component)
    if Instincts in table:
        table.set_defaults(Instincts, **{trait.partition(".")[0]: own for trait, own in networks.items()})
    table.species.own_ranges = frozenset(
        t.index for _, t in coded if (t.component, t.field) == ("Senses", "radius")
    )
    table.species.own_places = frozenset(
        t.index for _, t in coded if t.component == "Senses" and t.field in ("forward", "left")
    )
    for gene, trait in coded:
        if trait.name == "body.radius":
            table.species.radius = max([species.body.radius, *(gene.values or [gene.high or 0.0])])
    return {gene.name: (known[trait.component], trait.field, trait.index) for gene, trait in coded}
