"""Checks of one species' genome: what its genes name exists, and their values are possible."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.config.checks.actions import check_actions
from ecs_eco.config.checks.body import check_body, farthest
from ecs_eco.config.checks.matter import Key
from ecs_eco.config.checks.nerves import check_sensors
from ecs_eco.config.derived import all_genes, problems_of_derived
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.names import is_component
from ecs_eco.config.numbers import with_value
from ecs_eco.engine.errors import Problem, UnknownName
from ecs_eco.engine.section import LARGEST, SMALLEST, function_name
from ecs_eco.genomes.models import Gene, GenomeSection

if TYPE_CHECKING:
    from ecs_eco.genomes.layout import Layout
    from ecs_eco.genomes.traits import Trait


def check_genome(config: WorldConfig, name: str) -> Iterator[Problem]:
    """All problems of the species' genome."""
    species, key = config.species[name], ("species", name, "genome")
    section: GenomeSection | None = getattr(species, "genome", None)
    if section is None:
        return
    from ecs_eco.config.shapes import shapes_of_networks
    from ecs_eco.config.traits import traits_of, why_shared
    from ecs_eco.genomes.problems import problems
    from ecs_eco.genomes.promoters import problems_of_variable

    yield from _check_connections(config, name)
    if (own := components_of(config, species)) is None:
        return  # its genes may name what is not loaded
    traits = traits_of(species, config.dims, own)
    shapes = shapes_of_networks(config, name)
    coded = {gene.trait for gene in section.genes}
    if "policy.weights" in traits and "policy.weights" in coded - shapes.keys():
        return  # the network is code that is not loaded, or that is refused elsewhere
    for word in ("reflex", "happiness"):
        if f"{word}.weights" in traits and f"{word}.weights" in coded - shapes.keys():
            function = getattr(species, word).function
            if config.known(function) is not None:
                fault = "no network, and a gene codes for its weights"
                yield Problem(
                    ("species", name, word, "function"),
                    fault,
                    function_name(function),
                    "what fit_network gives",
                )
            return
    loci = section.loci if section.longest is None else None
    own_problems = [
        *problems(section.genes, len(section.alphabet), loci, traits, shapes),
        *problems_of_variable(section, traits, shapes),
        *problems_of_derived(section, traits),
    ]
    for problem in own_problems:
        shared = why_shared(str(problem.value), type(species)) if problem.key[-1] == "trait" else ""
        why = {"what": f"no gene can code for it: {shared}", "nearest": ""} if shared else {}
        yield problem.moved(key=(*key, *problem.key), **why)
    whole = section.model_copy(update={"genes": all_genes(species)})
    for problem in _check_ranges(config, species, key, whole):
        yield _placed(problem, key, section, whole)
    yield from _check_brain(name, species, section)
    if not own_problems:
        from ecs_eco.genomes.of_section import layout_of

        layout = layout_of(section, traits, shapes)
        for problem in _check_extremes(config, name, key, whole, traits):
            yield _placed(problem, key, section, whole)
        yield from _check_operators(config, species, key, layout)
        yield from _check_founders(key, section, layout)


def _placed(problem: Problem, key: Key, section: GenomeSection, whole: GenomeSection) -> Problem:
    """The problem of a gene in `whole`; of a derived trait, which has no number, at its formula."""
    number = int(problem.key[len(key) + 1])
    if number < len(section.genes):
        return problem
    name = whole.genes[number].name
    what = f"{problem.what}: {problem.value:g}"
    return problem.moved(
        key=(*key, "derived", name, "formula"), what=what, value=section.derived[name].formula
    )


def components_of(config: WorldConfig, species: Species) -> list[Any] | None:
    """The user's own components of the species; None if they may not be loaded, or are invalid."""
    own = config.own_components(species)
    return own if all(map(is_component, own)) else None


def _check_connections(config: WorldConfig, name: str) -> Iterator[Problem]:
    """Problems of reflex connections that genes cannot distinguish."""
    from ecs_eco.config.traits import label_of

    reflex, seen = config.species[name].reflex, set()
    for i, connection in enumerate(reflex.connections if reflex else ()):
        if label_of(connection) in seen:
            key = ("species", name, "reflex", "connections", i, "name")
            yield Problem(
                key,
                "another connection has this name, so genes cannot name it",
                label_of(connection),
                "a name of its own",
            )
        seen.add(label_of(connection))


def _check_ranges(
    config: WorldConfig, species: Species, key: Key, section: GenomeSection
) -> Iterator[Problem]:
    """Problems of values of genes for which this world has no room."""
    most = min(config.space.size) / 2
    store = species.metabolism.energy_max
    fastest = max(species.locomotion.speed.values()) * config.dt if species.locomotion else 0.0
    for i, gene in enumerate(section.genes):
        highest = max(gene.values, default=0.0) if gene.values else gene.high
        field = "values" if gene.values else "high"
        if highest is None or gene.trait is None:
            continue
        if gene.trait == "body.radius" and highest > most:
            yield Problem(
                (*key, "genes", i, field),
                "the body would not fit into the world",
                highest,
                f"at most {most:g} m",
            )
        if gene.trait == "body.radius" and species.body.density is not None:
            yield from _check_masses(species, (*key, "genes", i), gene)
        if (
            gene.trait.startswith("sensors.")
            and gene.trait.endswith(".radius")
            and highest > config.space.widest
        ):
            yield Problem(
                (*key, "genes", i, field),
                config.space.too_wide,
                highest,
                f"at most {config.space.widest:g} m",
            )
        if gene.trait.startswith("sensors.") and gene.trait.endswith((".forward", ".left")):
            yield from _check_nose(config, species, (*key, "genes", i), gene)
        if gene.trait == "locomotion.pace" and highest * fastest > most:
            allowed = f"at most {most / fastest:g}"
            yield Problem(
                (*key, "genes", i, field), "further than half of the world in one tick", highest, allowed
            )
        if gene.trait in ("reproduction.energy_min", "reproduction.energy_given") and highest > store:
            yield Problem((*key, "genes", i, field), "more than energy_max", highest, f"at most {store:g}")


def _check_masses(species: Species, key: Key, gene: Gene) -> Iterator[Problem]:
    """Whether a gene for the radius makes masses, by the density, that no number holds."""
    ends = (
        [("values", v) for v in (min(gene.values), max(gene.values))]
        if gene.values
        else [("low", gene.low or 0.0), ("high", gene.high or 0.0)]
    )
    for field, radius in ends:
        mass = species.body.mass * (radius / species.body.radius) ** 3
        if radius > 0 and not SMALLEST <= mass <= LARGEST:
            yield Problem(
                (*key, field),
                f"density × volume would be {mass:g} kg",
                radius,
                f"{SMALLEST:g} to {LARGEST:g} kg",
            )


def _check_extremes(
    config: WorldConfig, name: str, key: Key, section: GenomeSection, traits: dict[str, Trait]
) -> Iterator[Problem]:
    """Problems of genes with whose least or greatest value the species itself would be refused."""
    species = config.species[name]

    def faults(changed: Any) -> list[Problem]:
        with_it = config.model_copy(update={"species": config.species | {name: changed}})
        return [
            *check_body(with_it, name),
            *check_sensors(with_it, name),
            *check_actions(with_it, ("species", name), changed),
        ]

    known = {(problem.key, problem.what) for problem in faults(species)}
    for i, gene in enumerate(section.genes):
        if (
            gene.trait is None
            or gene.trait not in traits
            or traits[gene.trait].component != "Traits"
            or gene.trait.endswith(".present")
        ):
            continue
        ends = (
            {"low": gene.low, "high": gene.high}
            if gene.values is None
            else {f"values.{gene.values.index(v)}": v for v in (min(gene.values), max(gene.values))}
        )
        for field, value in ends.items():
            if value is None:
                continue
            for problem in faults(with_value(species, tuple(gene.trait.split(".")), value)):
                if (problem.key, problem.what) not in known:
                    place = (*key, "genes", i, *(int(p) if p.isdigit() else p for p in field.split(".")))
                    what = ".".join(map(str, problem.key[2:]))
                    fault = f"the species would be refused with it: {what} would be {problem.what}"
                    yield Problem(place, fault, value, problem.allowed)
                    break


def _check_nose(config: WorldConfig, species: Species, key: Key, gene: Gene) -> Iterator[Problem]:
    """Whether a gene puts a sensor further off the body than the world is wide."""
    ends = (
        {"values": max(gene.values, key=abs)}
        if gene.values
        else {"low": gene.low or 0.0, "high": gene.high or 0.0}
    )
    most = farthest(config, species)
    for field, value in ends.items():
        if abs(value) > most:
            fault = "further off the body than the world is wide, in its radii"
            yield Problem((*key, field), fault, value, f"{-most:g} to {most:g}")


def _check_brain(name: str, species: Species, section: GenomeSection) -> Iterator[Problem]:
    """Whether policy.inherit and the genes agree on the origin of a brain's weights."""
    coded, key = (
        any(gene.trait == "policy.weights" for gene in section.genes),
        ("species", name, "policy", "inherit"),
    )
    inherit = species.policy.inherit
    if inherit == "birth" and not coded:
        yield Problem(
            key,
            "no gene codes for policy.weights",
            inherit,
            'a gene with trait = "policy.weights", or another way',
        )
    if inherit == "learned" and coded:
        yield Problem(key, "a gene codes for policy.weights too", inherit, '"birth", or no such gene')


def _check_founders(key: Key, section: GenomeSection, layout: Layout) -> Iterator[Problem]:
    """Whether genes can code for the values of founders."""
    for i, code in enumerate(layout.genes if section.founders == "own" else ()):
        if code.trait is None or code.width:
            continue
        try:
            code.numbers(np.array([code.trait.default]), clip=False)
        except ValueError as error:
            fault = f"it cannot code for the species' own value, {code.trait.default:g}"
            allowed = f'{str(error).partition("allowed are ")[2]}, or founders = "random"'
            yield Problem((*key, "genes", i, "trait"), fault, code.gene.trait, allowed)


def _check_operators(config: WorldConfig, species: Species, key: Key, layout: Layout) -> Iterator[Problem]:
    """Problems of the operators; whether that which crosses fits these genomes matters where it is used."""
    from ecs_eco.genomes.operators import check_entry, taken_apart

    for word in ("mate", "mutate"):
        entry, at = getattr(species.genome, word), (*key, word, "operator")
        named = isinstance(entry.operator, str) and ":" not in entry.operator
        try:
            if named:
                check_entry(word, entry.operator, entry.arguments, layout, species.mates or word != "mate")
            elif (own := config._code.known(entry.operator)) is not None:
                taken_apart(word, partial(own, **entry.arguments))
        except (ValueError, UnknownName) as error:
            value = (
                entry.operator
                if isinstance(entry.operator, str)
                else getattr(entry.operator, "__name__", "a function")
            )
            yield Problem(at, str(error).removeprefix(f"{word}: "), value)
