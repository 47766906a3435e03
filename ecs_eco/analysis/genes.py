"""Evolution of genes in a run: means and spread of quantitative genes, allele frequencies and selection, from all
births and deaths; `ecs_eco.analysis.compare_genes` computes intervals over runs."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.analysis.carriers import (
    Frequencies,
    frequencies,
    gene_of,
    genes_in,
    has_few_values,
    require_number,
    values_of,
)
from ecs_eco.analysis.pedigree import Pedigree

BINS = 40  # maximum number of bins for the values of a gene
SAMPLES = 400  # approximate maximum number per run


@dataclass(frozen=True)
class Course:
    """The values of a quantitative gene in living organisms, NaN if no organism with the gene is alive."""

    gene: str
    ticks: np.ndarray  # i64[samples]
    n: np.ndarray  # number of organisms
    mean: np.ndarray
    sd: np.ndarray
    edges: np.ndarray  # f64[bins + 1]
    share: np.ndarray  # fraction of values between adjacent edges, f64[samples, bins]


class Selection(NamedTuple):
    """The change in frequency of one allele of a gene relative to all its other alleles."""

    s: float  # slope of its log odds per generation
    per_tick: float
    generation: float  # mean generation time [ticks]
    samples: int  # number of time points used
    first: float  # allele frequency
    last: float


def few_valued(genomes: Mapping[str, Any]) -> list[str]:
    """Return a species' genes in the manifest that have few enough values for each to count as an allele."""
    return [g["name"] for g in genomes["genes"] if has_few_values(g)]


def quantitative(genomes: Mapping[str, Any]) -> list[str]:
    """Return a species' quantitative genes and derived traits in the manifest."""
    return [
        g["name"]
        for g in genes_in(genomes)
        if ("range" in g or "formula" in g or len(set(g.get("values", ()))) > 1) and not has_few_values(g)
    ]


def course(lineage: Pedigree, species: str, gene: str, every: int, bins: int = BINS) -> Course:
    """Return the mean, spread and distribution of a gene among living organisms, sampled every `every` ticks.

    Parameters
    ----------
    lineage : Lineage
    species : str
    gene : str
    every : int
        Ticks between samples.
    bins : int
        Maximum number of bins for the distribution.

    Returns
    -------
    Course
    """
    record = gene_of(lineage, species, gene)
    require_number(record, species)
    values, ticks = values_of(lineage, gene, species), lineage.samples(every)
    mask = np.isfinite(values)
    n = lineage.living_sums(ticks, mask=mask)
    there = np.where(n, n, np.nan)
    middle = float(values[mask].mean()) if mask.any() else 0.0  # centering keeps sums of squares accurate
    shifted = np.where(mask, values - middle, 0.0)
    mean = lineage.living_sums(ticks, shifted, mask) / there
    square = lineage.living_sums(ticks, shifted**2, mask) / there
    edges = edges_of(values, record.get("range", {}).get("scale") == "log", bins)
    which = np.clip(np.searchsorted(edges, values, "right") - 1, 0, len(edges) - 2)
    share = np.stack(
        [lineage.living_sums(ticks, mask=mask & (which == b)) / there for b in range(len(edges) - 1)], 1
    )
    sd = np.sqrt(np.maximum(square - mean**2, 0))
    return Course(record["name"], ticks, n, mean + middle, sd, edges, share)


def edges_of(values: np.ndarray, log: bool = False, bins: int = BINS) -> np.ndarray:
    """Return bin edges f64[bins + 1]: around each value if there are few, otherwise in equal steps (or factors)."""
    known = np.unique(values[np.isfinite(values)])
    if len(known) < 2:
        only = float(known[0]) if len(known) else 0.0
        return np.array([only - 0.5, only + 0.5])
    if len(known) <= bins:
        middle = (known[1:] + known[:-1]) / 2
        return np.concatenate([[2 * known[0] - middle[0]], middle, [2 * known[-1] - middle[-1]]])
    return (np.geomspace if log else np.linspace)(known[0], known[-1], bins + 1)


def generation_time(lineage: Pedigree, species: str) -> float:
    """Return the mean age of parents at the birth of their offspring, over all births of a species.

    Parameters
    ----------
    lineage : Lineage
    species : str

    Returns
    -------
    float
        Time [ticks]; NaN if no organism was born to parents.

    Notes
    -----
    This is the generation time T of age-structured populations (Charlesworth 1994, Evolution in
    age-structured populations, chapter 1), with each parent counted once per child.
    """
    of, lines = lineage.species == species, (lineage.mother, lineage.father)
    ages = np.concatenate([(lineage.born - lineage.born[line])[of & (line >= 0)] for line in lines])
    return float(ages.mean()) if ages.size else np.nan


def log_odds_slope(frequency: np.ndarray, time: np.ndarray, n: np.ndarray | float = 1.0) -> float:
    """Return the slope of ln(p / (1 − p)) over time, by least squares with weights n p (1 − p), the inverse
    variance of the log odds of n copies (Berkson 1944).

    Parameters
    ----------
    frequency : array of float, shape (times,)
        Frequency of one allele.
    time : array of float, shape (times,)
    n : array of float or float, default 1
        Number of copies at each time.

    Returns
    -------
    float
        NaN unless both alleles are present at two or more times.

    Notes
    -----
    If a type grows as exp(m₁ t) and all other types as exp(m₂ t), the slope is m₁ − m₂; with non-overlapping
    generations and fitnesses of 1 + s and 1, it is ln(1 + s) per generation (Crow and Kimura 1970, An
    introduction to population genetics theory, chapter 5). Lost and fixed alleles have zero weight.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.genes import log_odds_slope
    >>> generations = np.arange(20)
    >>> round(log_odds_slope(1 / (1 + np.exp(2 - 0.3 * generations)), generations), 3)
    0.3
    """
    p, t, n = np.broadcast_arrays(np.asarray(frequency, float), np.asarray(time, float), np.asarray(n, float))
    seen = np.isfinite(p) & (p > 0) & (p < 1) & (n > 0)
    p, t, n = p[seen], t[seen], n[seen]
    if len(np.unique(t)) < 2:
        return np.nan
    weight = n * p * (1 - p)
    odds = np.log(p / (1 - p))
    t = t - np.average(t, weights=weight)
    return float((weight * t) @ odds / ((weight * t) @ t))


def selection(
    lineage: Pedigree, species: str, gene: str, value: str, since: int = 0, until: int | None = None
) -> Selection:
    """Return the strength of selection on a value of a gene.

    Parameters
    ----------
    lineage : Lineage
    species : str
    gene : str
    value : str
    since : int, default 0
        First tick.
    until : int, optional
        Last tick; default: the end of the run.

    Returns
    -------
    Selection
        Slope of the logit of the allele frequency, per tick and per generation.

    Raises
    ------
    KeyError
        If the species, gene or value is unknown.

    Notes
    -----
    The slope per generation uses the species' mean generation time in this lineage, as Chevin (2011, Biology
    Letters 7, 210–213) recommends for overlapping generations. It is the net change relative to all other
    values, including mutation and drift; a neutral marker in the same genome shows how large they are."""
    counted = frequencies(lineage, species, gene, max(1, (lineage.end + 1) // SAMPLES))
    counted.of(value)  # an unknown value raises an error that suggests the closest one
    column = counted.values.index(value)
    return selection_of(
        counted.allele[:, column],
        counted.ticks,
        counted.copies.sum(axis=1),
        generation_time(lineage, species),
        since,
        until,
    )


def selection_of(
    frequency: np.ndarray,
    ticks: np.ndarray,
    n: np.ndarray,
    generation: float,
    since: int = 0,
    until: int | None = None,
) -> Selection:
    """Return the Selection of an allele from its frequency among n copies at these ticks."""
    within = (ticks >= since) & (ticks <= (ticks[-1] if until is None else until)) & np.isfinite(frequency)
    p = frequency[within]
    slope = log_odds_slope(p, ticks[within], n[within])
    ends = (float(p[0]), float(p[-1])) if p.size else (np.nan, np.nan)
    return Selection(slope * generation, slope, generation, int(((p > 0) & (p < 1)).sum()), *ends)


def selections(counted: Frequencies, generation: float) -> Iterator[tuple[str, np.ndarray, Selection]]:
    """Yield the name, allele frequencies and Selection of each value or, if there are two, of the second only."""
    n = counted.copies.sum(axis=1)
    for j in range(1 if len(counted.values) == 2 else 0, len(counted.values)):
        p = counted.allele[:, j]
        yield counted.values[j], p, selection_of(p, counted.ticks, n, generation)


def haldanes(course: Course, generation: float) -> float:
    """Return the rate of evolution of a quantitative gene: the change of its mean in standard deviations per
    generation (Gingerich 1993, American Journal of Science 293A, 453–478).

    Parameters
    ----------
    course : Course
    generation : float
        Generation time [ticks].

    Returns
    -------
    float
        The least-squares slope of the mean over ticks, divided by the within-population standard deviation
        pooled over time, times the generation time; NaN if nothing varies.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.genes import Course, haldanes
    >>> ticks, sd = np.arange(5), np.ones(5)
    >>> round(haldanes(Course("size", ticks, 10 * sd, 0.02 * ticks, sd, np.zeros(1), np.zeros((5, 0))), 10.0), 6)
    0.2
    """
    there = np.isfinite(course.mean)
    t, mean = course.ticks[there].astype(float), course.mean[there]
    if len(t) < 2:
        return np.nan
    sd = float(np.sqrt(np.average(course.sd[there] ** 2, weights=course.n[there])))
    t = t - t.mean()
    return float((t @ mean) / (t @ t) * generation / sd) if sd > 0 else np.nan
