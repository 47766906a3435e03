"""Problems with the genes of a layout, each with its key in the genome section."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from ecs_eco.engine.errors import MISSING, Problem, listed, nearest
from ecs_eco.genomes.codes import is_whole
from ecs_eco.genomes.models import Gene
from ecs_eco.genomes.traits import Shapes, Trait

Key = tuple[str | int, ...]
MOST_LEVELS = 2**31  # values of a codon
MOST_WEIGHT_LEVELS = 2**16
LONGEST = 50_000_000  # loci in a string


def problems(
    genes: Sequence[Gene],
    size: int,
    loci: int | None,
    traits: Mapping[str, Trait] | None,
    shapes: Mapping[str, Shapes],
) -> Iterator[Problem]:
    """Yield all problems with genes over an alphabet of `size` letters, on strings with `loci` loci (None: as
    many as needed).

    `traits` are the species' traits (None: any name); `shapes` are networks' shapes by trait or gene."""
    if not genes:
        yield Problem(("genes",), "is empty", allowed="at least one gene")
    names: set[str] = set()
    coded: dict[str, str] = {}
    for i, gene in enumerate(genes):
        key = ("genes", i)
        if gene.name in names:
            yield Problem((*key, "name"), "another gene has this name", gene.name, "each name once")
        names.add(gene.name)
        if gene.trait is not None and gene.trait in coded:
            what = f"the gene {coded[gene.trait]} also codes for it"
            yield Problem((*key, "trait"), what, gene.trait, "one gene for each trait")
        coded.setdefault(gene.trait or "", gene.name)
        if gene.trait is not None and traits is not None and gene.trait not in traits:
            known, near = listed(traits, 40), nearest(gene.trait, traits)
            yield Problem((*key, "trait"), "the species has no such trait", gene.trait, known, near)
            continue
        trait = (traits or {}).get(gene.trait or "")
        most = MOST_WEIGHT_LEVELS if is_weights(gene, trait) else MOST_LEVELS
        if size**gene.letters > most:
            fault = f"codon is too long: it would have {size}^{gene.letters} values"
            fit = max(letters for letters in range(1, 32) if size**letters <= most)
            yield Problem((*key, "letters"), fault, gene.letters, f"at most {fit}")
        elif is_weights(gene, trait):
            yield from _of_weights(key, gene, shapes)
        else:
            yield from _of_value(key, gene, size, trait)
    yield from _of_places(genes, loci, traits or {}, shapes)


def is_weights(gene: Gene, trait: Trait | None) -> bool:
    """Return whether a gene codes for the weights of a network."""
    of_trait = gene.trait == "policy.weights" or (trait is not None and trait.kind == "weights")
    return gene.form is not None or of_trait


def shapes_of(gene: Gene, shapes: Mapping[str, Shapes]) -> Shapes | None:
    """Return the shapes of the network that a gene codes for, if known."""
    return shapes.get(gene.name, shapes.get(gene.trait or ""))


def n_codons(gene: Gene, trait: Trait | None, shapes: Mapping[str, Shapes]) -> int | None:
    """Return how many codons a gene has; None if the shapes of its network are unknown."""
    if not is_weights(gene, trait):
        return gene.codons
    known = shapes_of(gene, shapes)
    if known is None or (gene.form == "cosine" and gene.coefficients is None):
        return None
    most = gene.coefficients if gene.form == "cosine" and gene.coefficients else LONGEST
    return sum(min(most, math.prod(shape)) for shape in known)


def places(
    genes: Sequence[Gene], traits: Mapping[str, Trait], shapes: Mapping[str, Shapes]
) -> list[tuple[int, int]] | None:
    """Return each gene's first locus and the locus after its last one; None if any length is unknown."""
    spans, at = [], 0
    for gene in genes:
        n = n_codons(gene, traits.get(gene.trait or ""), shapes)
        if n is None:
            return None
        first = at if gene.at is None else gene.at
        at = first + n * gene.letters
        spans.append((first, at))
    return spans


def _of_places(
    genes: Sequence[Gene], loci: int | None, traits: Mapping[str, Trait], shapes: Mapping[str, Shapes]
) -> Iterator[Problem]:
    spans = places(genes, traits, shapes)
    if spans is None:
        return
    order = sorted(range(len(genes)), key=lambda i: spans[i])
    for before, i in zip(order, order[1:], strict=False):
        if spans[i][0] < spans[before][1]:
            fault = (
                f"overlaps the gene {genes[before].name}, "
                f"which occupies loci {spans[before][0]} to {spans[before][1] - 1}"
            )
            yield Problem(("genes", i, "at"), fault, spans[i][0], f"at least {spans[before][1]}")
    needed = max((stop for _, stop in spans), default=0)
    if loci is not None and loci < needed:
        yield Problem(
            ("loci",), f"string is too short: the genes need {needed} loci", loci, f"at least {needed}"
        )
    elif needed > LONGEST:
        yield Problem(("genes",), f"the genes need {needed} loci", allowed=f"at most {LONGEST}")


def _faults(key: Key, gene: Gene, faults: Iterable[tuple[bool, str, str, str]]) -> Iterator[Problem]:
    """Yield the problems with a gene; `faults` are tuples (exists, field, description, expected value)."""
    for wrong, field, what, allowed in faults:
        if wrong:
            value = getattr(gene, field)
            yield Problem((*key, field), what, MISSING if value is None else value, allowed)


def _of_weights(key: Key, gene: Gene, shapes: Mapping[str, Shapes]) -> Iterator[Problem]:
    noun, more = "the weights of a network", gene.coefficients is not None
    nothing = 'form = "cosine", or remove this key'
    faults = (
        (gene.form is None, "form", f"is missing: the gene codes for {noun}", "direct or cosine"),
        (gene.values is not None, "values", f"has no effect for {noun}", "low and high"),
        (gene.codons > 1, "codons", f"has no effect for {noun}", "low and high"),
        (gene.whole, "whole", f"has no effect for {noun}", "low and high"),
        (gene.code == "additive", "code", f"not possible for {noun}", "positional or gray"),
        (gene.scale == "log", "scale", f"not possible for {noun}", "linear"),
        (
            gene.form == "cosine" and not more,
            "coefficients",
            "is missing: the number for each matrix",
            "a whole number from 1",
        ),
        (gene.form == "direct" and more, "coefficients", "has no effect: every weight has a codon", nothing),
    )
    yield from _faults(key, gene, faults)
    yield from _of_range(key, gene, None)
    if shapes_of(gene, shapes) is None:
        allowed = 'trait = "policy.weights", or shapes = {gene: [...]}'
        yield Problem((*key, "form"), "the network that it codes for is unknown", gene.form, allowed)


def _of_value(key: Key, gene: Gene, size: int, trait: Trait | None) -> Iterator[Problem]:
    adds, n = gene.code == "additive", gene.codons
    unused, few = f'has no effect with code = "{gene.code}"', 'too few codons for code = "additive"'
    faults = (
        (
            gene.coefficients is not None,
            "coefficients",
            "only for the weights of a network",
            "remove this key",
        ),
        (adds and n < 2, "codons", few, "at least 2"),
        (not adds and n > 1, "codons", unused, 'code = "additive", or 1'),
    )
    yield from _faults(key, gene, faults)
    if gene.values is None:
        yield from _of_range(key, gene, trait)
        return
    for field, default in {"low": None, "high": None, "code": "positional", "scale": "linear"}.items():
        if (value := getattr(gene, field)) != default:
            yield Problem((*key, field), "given together with values", value, "one of them")
    if len(gene.values) != (levels := size**gene.letters):
        fault = f"{len(gene.values)} values, but a codon of {gene.letters} of {size} letters has {levels}"
        yield Problem((*key, "values"), fault, gene.values, f"{levels} numbers")
    for j, value in enumerate(gene.values):
        yield from _of_bound((*key, "values", j), gene, trait, value)


def _of_range(key: Key, gene: Gene, trait: Trait | None) -> Iterator[Problem]:
    for field, end in {"low": gene.low, "high": gene.high}.items():
        if end is None:
            allowed = "a number" if is_weights(gene, trait) else "a number, or values for each codon"
            yield Problem((*key, field), "is missing", allowed=allowed)
        else:
            yield from _of_bound((*key, field), gene, trait, end)
    if gene.low is None or gene.high is None:
        return
    if gene.low >= gene.high:
        yield Problem((*key, "low"), "not below high", gene.low, f"less than {gene.high:g}")
    if gene.scale == "log" and is_whole(gene, trait):
        yield Problem((*key, "scale"), "not possible for whole numbers", gene.scale, "linear")
    elif gene.scale == "log" and gene.low <= 0:
        yield Problem((*key, "low"), "has no logarithm", gene.low, "more than 0")


def _of_bound(key: Key, gene: Gene, trait: Trait | None, value: float) -> Iterator[Problem]:
    if is_whole(gene, trait) and value != round(value):
        yield Problem(key, "not a whole number", value, "a whole number")
    if trait is not None and not trait.low <= value <= trait.high:
        unit = "" if trait.unit == "1" else f" {trait.unit}"
        yield Problem(
            key, f"outside the range of {trait.name}", value, f"{trait.low:g} to {trait.high:g}{unit}"
        )
