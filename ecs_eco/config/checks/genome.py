"""Checks of one species' genome: whether the traits of its genes exist and their values are possible."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from ecs_eco.config.checks.actions import check_actions
from ecs_eco.config.checks.body import check_body, farthest
from ecs_eco.config.checks.nerves import check_sensors
from ecs_eco.config.derived import all_genes, problems_of_derived
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.names import is_component
from ecs_eco.config.numbers import with_value
from ecs_eco.config.rules import Key, at_most
from ecs_eco.config.shapes import shapes_of_networks
from ecs_eco.config.traits import label_of, traits_of, why_shared
from ecs_eco.engine.errors import Problem, UnknownName
from ecs_eco.genomes.layout import Layout
from ecs_eco.genomes.models import Gene, GenomeSection
from ecs_eco.genomes.operators import check_entry, taken_apart
from ecs_eco.genomes.problems import problems
from ecs_eco.genomes.promoters import problems_of_variable
from ecs_eco.genomes.traits import Trait
from ecs_eco.genomes.variable_layout import layout_of
from ecs_eco.inputs.section import LARGEST, SMALLEST, function_name


def check_genome(config: WorldConfig, name: str) -> Iterator[Problem]:
    """Yield all problems with the species' genome."""
    species, key = config.species[name], ("species", name, "genome")
    if (section := species.genome) is None:
        return
    yield from _check_connections(name, species)
    if (own := components_of(config, species)) is None:
        return  # its genes might name code that is not loaded
    traits = traits_of(species, config.dims, own)
    shapes = shapes_of_networks(config, name)
    absent = ({gene.trait for gene in section.genes} & traits.keys()) - shapes.keys()
    if "policy.weights" in absent:
        return  # the network's code is not loaded, or another check rejects it
    for word in ("reflex", "happiness"):
        if f"{word}.weights" in absent:
            function = getattr(species, word).function
            if config.known(function) is not None:
                at, fault = (
                    ("species", name, word, "function"),
                    "it is not a network, but a gene codes for its weights",
                )
                yield Problem(at, fault, function_name(function), "the result of fit_network")
            return
    loci = section.loci if section.max_length is None else None
    faults = [
        *problems(section.genes, len(section.alphabet), loci, traits, shapes),
        *problems_of_variable(section, traits, shapes),
        *problems_of_derived(section, traits),
    ]
    for problem in faults:
        shared = why_shared(str(problem.value), type(species)) if problem.key[-1] == "trait" else ""
        why = {"what": f"no gene can code for it: {shared}", "nearest": ""} if shared else {}
        yield problem.moved(key=(*key, *problem.key), **why)
    whole = section.model_copy(update={"genes": all_genes(species)})
    for i, gene in enumerate(whole.genes):
        for problem in _check_range(config, species, (*key, "genes", i), gene):
            yield _placed(problem, key, section, whole)
    yield from _check_brain(name, species, section)
    if not faults:
        layout = layout_of(section, traits, shapes)
        for problem in _check_extremes(config, name, key, whole, traits):
            yield _placed(problem, key, section, whole)
        yield from _check_operators(config, species, key, layout)
        yield from _check_founders(key, section, layout)


def _placed(problem: Problem, key: Key, section: GenomeSection, whole: GenomeSection) -> Problem:
    """Return the problem with a gene in `whole`, located at the formula if the gene is a derived trait."""
    number = int(problem.key[len(key) + 1])
    if number < len(section.genes):
        return problem
    name = whole.genes[number].name
    what = f"{problem.what}: {problem.value:g}"
    return problem.moved(
        key=(*key, "derived", name, "formula"), what=what, value=section.derived[name].formula
    )


def components_of(config: WorldConfig, species: Species) -> list[Any] | None:
    """Return the species' custom components; None if they are invalid or are not allowed to be loaded."""
    own = config.own_components(species)
    return own if all(map(is_component, own)) else None


def _check_connections(name: str, species: Species) -> Iterator[Problem]:
    """Yield problems with reflex connections that genes cannot distinguish."""
    seen = set[str]()
    for i, connection in enumerate(species.reflex.connections if species.reflex else ()):
        if (label := label_of(connection)) in seen:
            key = ("species", name, "reflex", "connections", i, "name")
            fault = "another connection has this name, so genes cannot refer to it"
            yield Problem(key, fault, label, "a unique name")
        seen.add(label)


def _check_range(config: WorldConfig, species: Species, key: Key, gene: Gene) -> Iterator[Problem]:
    """Yield problems with gene values that are not valid in this world."""
    most, trait = min(config.space.size) / 2, gene.trait
    fastest = max(species.locomotion.speed.values()) * config.dt if species.locomotion else 0.0
    highest = max(gene.values) if gene.values else gene.high
    at = (*key, "values" if gene.values else "high")
    if highest is None or trait is None:
        return
    if trait == "body.radius":
        yield from at_most(at, "the body would not fit into the world", highest, most)
        yield from _check_masses(species, key, gene)
    if trait.startswith("sensors.") and trait.endswith(".range"):
        yield from at_most(at, config.space.too_wide, highest, config.space.widest)
    if trait.startswith("sensors.") and trait.endswith((".forward", ".left")):
        farthest_off = farthest(config, species)
        for field, value in _ends(gene):
            if abs(value) > farthest_off:
                fault = "farther from the body than the width of the world, in body radii"
                yield Problem((*key, field), fault, value, f"{-farthest_off:g} to {farthest_off:g}")
    if trait == "locomotion.pace" and highest * fastest > most:
        fault = "moves more than half the world's width in a tick"
        yield Problem(at, fault, highest, f"at most {most / fastest:g}")
    if trait in ("reproduction.energy_min", "reproduction.energy_given"):
        yield from at_most(at, "more than energy_max", highest, species.metabolism.energy_max, "")


def _ends(gene: Gene) -> list[tuple[str, float]]:
    """Return the minimum and maximum of a gene, with their fields."""
    if gene.values:
        return [("values", min(gene.values)), ("values", max(gene.values))]
    return [("low", gene.low or 0.0), ("high", gene.high or 0.0)]


def _check_masses(species: Species, key: Key, gene: Gene) -> Iterator[Problem]:
    """Yield a problem if a gene for the radius, combined with the density, leads to out-of-range masses."""
    for field, radius in _ends(gene) if species.body.density is not None else ():
        mass = species.body.mass * (radius / species.body.radius) ** 3
        if radius > 0 and not SMALLEST <= mass <= LARGEST:
            fault = f"density × volume would be {mass:g} kg"
            yield Problem((*key, field), fault, radius, f"{SMALLEST:g} to {LARGEST:g} kg")


def _check_extremes(
    config: WorldConfig, name: str, key: Key, section: GenomeSection, traits: dict[str, Trait]
) -> Iterator[Problem]:
    """Yield problems with genes whose minimum or maximum would make the species itself invalid."""
    species = config.species[name]

    def faults(changed: Species) -> list[Problem]:
        with_it = config.model_copy(update={"species": config.species | {name: changed}})
        return [
            *check_body(with_it, name),
            *check_sensors(with_it, name),
            *check_actions(with_it, ("species", name), changed),
        ]

    known = {(problem.key, problem.what) for problem in faults(species)}
    for i, gene in enumerate(section.genes):
        trait = traits.get(gene.trait or "")
        if trait is None or trait.component != "Traits" or trait.name.endswith(".present"):
            continue
        ends: dict[Key, float | None] = {("low",): gene.low, ("high",): gene.high}
        if gene.values is not None:
            ends = {("values", gene.values.index(v)): v for v in (min(gene.values), max(gene.values))}
        for field, value in ends.items():
            changed = species if value is None else with_value(species, tuple(trait.name.split(".")), value)
            new = (p for p in faults(changed) if (p.key, p.what) not in known)
            if (problem := next(new, None)) is not None:
                what = ".".join(map(str, problem.key[2:]))
                fault = f"this value would make the species invalid: {what}: {problem.what}"
                yield Problem((*key, "genes", i, *field), fault, value, problem.allowed)


def _check_brain(name: str, species: Species, section: GenomeSection) -> Iterator[Problem]:
    """Yield a problem unless policy.inherit and the genes agree on where a brain's weights come from."""
    coded = any(gene.trait == "policy.weights" for gene in section.genes)
    key, inherit = ("species", name, "policy", "inherit"), species.policy.inherit
    if inherit == "birth" and not coded:
        allowed = 'a gene with trait = "policy.weights", or another value here'
        yield Problem(key, "no gene codes for policy.weights", inherit, allowed)
    if inherit == "learned" and coded:
        yield Problem(key, "a gene also codes for policy.weights", inherit, '"birth", or remove this gene')


def _check_founders(key: Key, section: GenomeSection, layout: Layout) -> Iterator[Problem]:
    """Yield a problem if the genes cannot code for the founders' values."""
    for i, code in enumerate(layout.genes if section.founders == "own" else ()):
        if code.trait is None or code.width:
            continue
        try:
            code.numbers(np.array([code.trait.default]), clip=False)
        except ValueError as error:
            fault = f"it cannot code for the species' value, {code.trait.default:g}"
            allowed = f'{str(error).partition("expected ")[2]}, or founders = "random"'
            yield Problem((*key, "genes", i, "trait"), fault, code.gene.trait, allowed)


def _check_operators(config: WorldConfig, species: Species, key: Key, layout: Layout) -> Iterator[Problem]:
    """Yield problems with the genetic operators; crossover is checked against these genomes only if used."""
    for word in ("mate", "mutate"):
        entry = getattr(species.genome, word)
        operator = entry.operator
        try:
            if isinstance(operator, str) and ":" not in operator:
                check_entry(word, operator, entry.arguments, layout, species.mates or word != "mate")
            elif (own := config._code.known(operator)) is not None:
                taken_apart(word, partial(own, **entry.arguments))
        except (ValueError, UnknownName) as error:
            shown = operator if isinstance(operator, str) else getattr(operator, "__name__", "a function")
            yield Problem((*key, word, "operator"), str(error).removeprefix(f"{word}: "), shown)
