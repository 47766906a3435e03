"""From a species' genome section to its heredity: layout, operators, and the columns that its genes write."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco import components as own
from ecs_eco.components import Experience, Genome, Gestation, Memory, Policy
from ecs_eco.config.traits import policy_shapes, traits_of
from ecs_eco.genomes.heredity import Heredity

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

Targets = dict[str, tuple[type, str, int | None]]


def add_heredity(world: SpatialWorld, table: Table, species: Any, founder: np.ndarray | None = None) -> None:
    """Give a table its genome, the columns that its genes write, and those of individual brains,
    as far as it needs them."""
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
    layout, operators, targets, alike = None, None, {}, None
    if section is not None:
        from ecs_eco.genomes import Layout, Operators

        traits = traits_of(species, world.config.dims, [world.config.function(c) for c in species.components])
        shapes = policy_shapes(species, world.config.dims) if minds is None else minds.shapes
        layout = Layout.from_config(section, traits, shapes=shapes)
        choice = getattr(species.reproduction, "choice", "nearest")
        operators = Operators.from_config(section, layout, choice, world.config.function)
        table.dims |= {"loci": layout.row, "highest letter": len(layout.alphabet) - 1}
        table.add_component(Genome)
        targets = _targets(table, species, layout, traits)
        if section.founders == "own":
            alike = layout.own()[0], layout.coded()
    if species.reproduction is not None and species.reproduction.kind == "sexual":
        table.dims.setdefault("loci", 0)
        table.add_component(Gestation)
    if section is not None or minds is not None:
        table.species.heredity = Heredity(layout, operators, targets, minds=minds,
                                            inherit=species.policy.inherit,
                                            noise=species.policy.mutation, founder=founder, alike=alike)


def _targets(table: Table, species: Any, layout: Any, traits: dict[str, Any]) -> Targets:
    """Add the components that genes write to, with the species' own values as defaults;
    return where each gene writes."""
    coded = [(code.gene, traits[code.gene.trait]) for code in layout.genes
             if code.gene.trait is not None and (code.gene.trait != "policy.weights" or Policy in table)]
    used = {trait.component for _, trait in coded}
    known = {c.__name__: c for c in (*table.columns, *(getattr(own, n) for n in own.__all__))}
    table.dims |= {"sensors": len(species.sensors),
                   "connections": len(species.reflex.connections if species.reflex else ()),
                   "desires": len(species.happiness.weights if species.happiness else ())}
    for trait in traits.values():
        if trait.component in used and trait.component not in ("Policy", "Body"):
            component = known[trait.component]
            if component not in table:
                table.add_component(component)
            column = table.defaults[component][trait.field]
            column[... if trait.index is None else trait.index] = trait.default
    table.species.own_ranges = frozenset(t.index
                                         for _, t in coded if (t.component, t.field) == ("Senses", "radius"))
    table.species.own_places = frozenset(t.index for _, t in coded
                                         if t.component == "Senses" and t.field in ("forward", "left"))
    for gene, trait in coded:
        if trait.name == "body.radius":
            table.species.radius = max([species.body.radius, *(gene.values or [gene.low, gene.high])])
        if trait.name == "body.mass":
            table.species.standard_mass = species.body.mass
    return {gene.name: (known[trait.component], trait.field, trait.index) for gene, trait in coded}

