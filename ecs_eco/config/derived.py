"""Derived traits of a genome: formulas over gene values, so that a gene can have several effects (pleiotropy)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.config.formula import Formula, FormulaError, compile_formula
from ecs_eco.engine.errors import Problem, listed, nearest, unknown
from ecs_eco.genomes.models import Gene, GenomeSection
from ecs_eco.genomes.problems import is_weights
from ecs_eco.genomes.traits import Trait
from ecs_eco.inputs.section import LARGEST

if TYPE_CHECKING:
    from ecs_eco.config.models.species import Species

SAMPLES = 4096  # combinations of gene values at which a formula is checked
MOST_GENES = 12  # genes that vary in these samples; the others stay at their minimum


def all_genes(species: Species) -> list[Gene]:
    """Return the genes of a species, then its derived traits as genes with the ranges of their formulas."""
    if species.genome is None:
        return []
    section, derived = species.genome, []
    formulas, _ = formulas_of(section)
    for name in formulas:
        found = np.asarray(_samples(section, formulas, name)[name], np.float64)
        found = np.clip(np.nan_to_num(found), -LARGEST, LARGEST)  # values beyond these limits are rejected
        low, high = float(found.min()), float(found.max())
        derived.append(Gene(name=name, trait=section.derived[name].trait, letters=1, low=low, high=high))
    return [*section.genes, *derived]


def formulas_of(section: GenomeSection) -> tuple[dict[str, Formula], list[Problem]]:
    """Return the formulas of derived traits, each after the formulas that it reads, and any problems."""
    genes = [gene.name for gene in section.genes if not is_weights(gene, None)]
    known, found, wrong = [*genes, *section.derived], {}, []
    for name, derived in section.derived.items():
        key, text = ("derived", name, "formula"), derived.formula
        if any(gene.name == name for gene in section.genes):
            wrong.append(Problem(key[:2], "a gene has this name", name, "each name once"))
            continue
        if strange := [other for other in derived.read if other not in known]:
            wrong.append(unknown(("derived", name, "from"), "gene or derived trait", strange[0], known))
            continue
        try:
            formula = compile_formula(text, derived.read)
        except FormulaError as error:
            wrong.append(Problem(key, error.what, text, error.allowed, error.nearest))
            continue
        if not formula.names:
            wrong.append(Problem(key, "reads no gene", text, f"a formula of {listed(derived.read, 30)}"))
        elif unread := [other for other in derived.read if other not in formula.names]:
            fault, allowed = f"the formula does not read {unread[0]}", listed(formula.names, 30)
            wrong.append(Problem(("derived", name, "from"), fault, getattr(derived, "from"), allowed))
        else:
            found[name] = formula
    formulas: dict[str, Formula] = {}
    while ready := [n for n, f in found.items() if n not in formulas and f.names <= {*genes, *formulas}]:
        formulas |= {name: found[name] for name in ready}
    for name in [] if wrong else [name for name in found if name not in formulas]:
        fault = "circular: it reads itself, directly or through other formulas"
        wrong.append(Problem(("derived", name, "formula"), fault, found[name].text, listed(genes, 30)))
    return formulas, wrong


def problems_of_derived(section: GenomeSection, traits: Mapping[str, Trait]) -> Iterator[Problem]:
    """Yield problems with derived traits, with keys relative to the genome's section."""
    formulas, wrong = formulas_of(section)
    yield from wrong
    by_trait = {gene.trait: gene.name for gene in section.genes}
    numbers = [name for name, trait in traits.items() if trait.kind != "weights"]
    for name, derived in section.derived.items():
        key = ("derived", name)
        if derived.trait in by_trait:
            fault = f"{by_trait[derived.trait]} also codes for it"
            yield Problem((*key, "trait"), fault, derived.trait, "one gene or formula per trait")
        by_trait.setdefault(derived.trait, name)
        if derived.trait not in numbers:
            close = nearest(derived.trait, numbers)
            yield Problem(
                (*key, "trait"), "the species has no such trait", derived.trait, listed(numbers, 40), close
            )
        elif name in formulas:
            yield from _of_range(section, formulas, name, traits[derived.trait])


def _of_range(
    section: GenomeSection, formulas: Mapping[str, Formula], name: str, trait: Trait
) -> Iterator[Problem]:
    """Yield a problem if a formula can give values that its trait cannot have."""
    values = _samples(section, formulas, name)
    out = np.asarray(values[name], np.float64)
    out = np.rint(out) if trait.kind in ("whole", "sign") else out
    low, high = trait.low - 1e-6 * abs(trait.low), trait.high + 1e-6 * abs(trait.high)  # float32
    wrong = np.flatnonzero(~((out >= low) & (out <= high)))
    if wrong.size:
        at = ", ".join(f"{g} = {values[g][wrong[0]]:g}" for g in _genes_read(section, formulas, name))
        unit = "" if trait.unit == "1" else f" {trait.unit}"
        fault = f"{out[wrong[0]]:g} at {at}, which is outside the range of {trait.name}"
        allowed = f"{trait.low:g} to {trait.high:g}{unit}"
        yield Problem(("derived", name, "formula"), fault, formulas[name].text, allowed)


def _genes_read(section: GenomeSection, formulas: Mapping[str, Formula], name: str) -> list[str]:
    """Return the genes that a formula reads, directly or through other formulas, in the genome's order."""
    read, left = set[str](), [name]
    while left:
        for other in formulas[left.pop()].names - read:
            read.add(other)
            left += [other] if other in formulas else []
    return [gene.name for gene in section.genes if gene.name in read and gene.name not in formulas]


def _samples(section: GenomeSection, formulas: Mapping[str, Formula], name: str) -> dict[str, np.ndarray]:
    """Return sampled values of the genes, f64[samples], and formulas, f32[samples], that a formula reads."""
    genes = {gene.name: gene for gene in section.genes}
    read = _genes_read(section, formulas, name)
    n = max(2, int(SAMPLES ** (1 / len(read))))
    grid = np.meshgrid(*(_values_of(genes[gene], n) for gene in read[:MOST_GENES]))
    values: dict[str, np.ndarray] = {gene: axis.ravel() for gene, axis in zip(read, grid, strict=False)}
    values |= {gene: np.full(grid[0].size, _values_of(genes[gene], 1)[0]) for gene in read[MOST_GENES:]}
    for other, formula in formulas.items():
        if formula.names <= values.keys():
            values[other] = formula({name: values[name] for name in formula.names})
    return values


def _values_of(gene: Gene, n: int) -> np.ndarray:
    """Return at most n values of a gene, including its minimum and maximum."""
    if gene.values is not None:
        values = np.unique(gene.values or [0.0])
        return values[np.unique(np.linspace(0, values.size - 1, n).astype(int))]
    low, high = gene.low or 0.0, gene.high or 0.0
    values = np.geomspace(low, high, n) if gene.scale == "log" and low > 0 else np.linspace(low, high, n)
    return np.unique(np.rint(values)) if gene.whole else values
