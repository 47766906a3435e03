"""Frequencies of all alleles of a species: letters, values and copies of genes, haplotypes, and clades."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from ecs_eco.analysis.carriers import alleles_of, gene_of, has_few_values
from ecs_eco.analysis.pedigree import Pedigree
from ecs_eco.explain.drift import Steps, steps_of
from ecs_eco.explain.edits import limit_of

COMMON = 0.05  # frequency that a haplotype or a clade must reach
FEWEST = 5  # copies of an allele, and of all others, below which a step is left out
Kind = Literal["letter", "value", "copies", "haplotype", "clade"]


@dataclass(frozen=True)
class Allele:
    """A variant that organisms of a species carry.

    `gene` is "" if there is none, and `locus` −1. The `value` of a clade is the uid of its founder, and that of
    copies a limit, "2 or more" or "1 or fewer".

    Examples
    --------
    >>> from ecs_eco.explain import Allele
    >>> Allele("goat", "letter", "red", 12, "T").name, Allele("goat", "value", "red", -1, "-1").name
    ('letter T at locus 12 (gene red)', 'red = −1')
    >>> Allele("goat", "copies", "shy", -1, "2 or more").name, Allele("goat", "clade", "", -1, "17").name
    ('2 or more copies of shy', 'clade of organism 17')
    """

    species: str
    kind: Kind
    gene: str
    locus: int
    value: str

    @property
    def name(self) -> str:
        """Its name in plain English."""
        if self.kind == "letter":
            return f"letter {self.value} at locus {self.locus}" + f" (gene {self.gene})" * bool(self.gene)
        if self.kind == "value":
            return f"{self.gene} = {self.value.replace('-', '−')}"
        if self.kind == "copies":
            number = "0" if self.value == "0 or fewer" else self.value
            return f"{number} {'copy' if number == '1' else 'copies'} of {self.gene}"
        if self.kind == "clade":
            return f"clade of organism {self.value}"
        return f"haplotype {self.value if len(self.value) <= 24 else self.value[:23] + '…'}"


@dataclass(frozen=True)
class Paths:
    """The frequencies of alleles over time.

    Attributes
    ----------
    ticks : array of int64, shape (samples,)
    alleles : tuple of Allele
        Alleles of which at least 5 copies, and at least 5 copies of other alleles, were alive at some sample.
    p : array of float64, shape (samples, alleles)
        Frequency among the copies of living organisms; for values of genes in genomes of variable length, the
        mean over organisms of the share of their copies. NaN if no organism is alive.
    n : array of int64, shape (samples,)
        Gene copies: living organisms times ploidy.
    variance : array of float64, shape (samples, alleles)
        Variance of the share among living organisms.
    gain : array of float64, shape (samples − 1, alleles)
        Sum over organisms of share × excess contribution in each step, in newborns.
    used : array of bool, shape (samples − 1, alleles)
        Steps that begin with at least 5 copies of the allele and 5 of others; for haplotypes and clades, from
        the sample at which they first reach 5%.
    steps : Steps
        Steps between samples.
    """

    ticks: np.ndarray
    alleles: tuple[Allele, ...]
    p: np.ndarray
    n: np.ndarray
    variance: np.ndarray
    gain: np.ndarray
    used: np.ndarray
    steps: Steps


@dataclass(frozen=True)
class Site:
    """Alleles that exclude each other: `codes`[string][organism] is the index of a copy's value, −1 for no
    copy; `weights` f64[organisms], or one number, is the weight of each of an organism's copies."""

    kind: Kind
    gene: str
    locus: int
    values: tuple[str, ...]
    codes: list[np.ndarray]
    weights: np.ndarray | float

    def sums(self, at: np.ndarray, weights: np.ndarray, n: int, organism: np.ndarray) -> np.ndarray:
        """Return, for each of n places and each value, the sum of weights f64[rows] × the organism's share over
        the rows `at` i64[rows] this place: f64[n, values]."""
        size = len(self.values) + 1
        own = self.weights if isinstance(self.weights, float) else self.weights[organism]
        sums = [np.bincount(at * size + of[organism] + 1, weights * own, n * size) for of in self.codes]
        return np.asarray(np.sum(sums, axis=0).reshape(n, size)[:, 1:])

    def share(self, value: str, rows: np.ndarray | slice) -> np.ndarray:
        """Return the share of copies of these organisms that have a value: f64[rows]."""
        j = self.values.index(value) if value in self.values else len(self.values)
        own = self.weights if isinstance(self.weights, float) else self.weights[rows]
        return np.asarray(np.sum([codes[rows] == j for codes in self.codes], axis=0) * own)

    def pairs(self) -> "Site":
        """Return pairs of an organism's copies as a site, whose shares are the squares of this site's."""
        same = [np.where(a == b, a, a.dtype.type(-1)) for a in self.codes for b in self.codes]
        return replace(self, codes=same, weights=self.weights**2)


def follow(lineage: Pedigree, species: str, every: int | None = None) -> Paths:
    """Return the frequencies of all alleles of a species over time.

    Parameters
    ----------
    lineage : Lineage
    species : str
    every : int, optional
        Ticks between samples; default: half a generation, or longer to have at most 1,000 steps.

    Returns
    -------
    Paths
        Only clades if the record contains no genomes of this species.

    Raises
    ------
    KeyError
        If the species is unknown.
    ValueError
        If none of its organisms was born to recorded parents, or the run is shorter than a step.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.lineage import Lineage
    >>> from ecs_eco.explain import follow
    >>> uid, zero = np.arange(1, 41, dtype=np.uint64), np.zeros(20, np.uint64)
    >>> parent = np.concatenate([zero, np.repeat(uid[:10], 2)])
    >>> born, died = np.repeat([0, 2], 20), np.repeat([3, -1], 20)
    >>> text = np.array(list("A" * 10 + "C" * 10 + "A" * 20), object)
    >>> causes = np.full(40, "", object)
    >>> genomes = {"rat": {"alphabet": "ACGT", "ploidy": 1, "genes": []}}
    >>> rats = Lineage(uid, parent, 0 * uid, np.full(40, "rat"), born, died, causes, text, 4, 1.0, genomes)
    >>> paths = follow(rats, "rat")
    >>> paths.ticks.tolist(), paths.alleles[0].name
    ([0, 1, 2, 3, 4], 'letter A at locus 0')
    >>> paths.p[:, 0].tolist()
    [0.5, 0.5, 0.75, 1.0, 1.0]
    """
    own = lineage.of_species(species)
    steps = steps_of(own, every)
    parts = [_path(site, species, steps) for site in Carried(own, species).sites(steps)]
    alleles = tuple(allele for found, *_ in parts for allele in found)
    p, variance, gain, used = (np.concatenate([part[i] for part in parts], axis=1) for i in range(1, 5))
    n = steps.living * int(own.genomes.get(species, {}).get("ploidy", 1))
    return Paths(steps.ticks, alleles, p, n, variance, gain, used, steps)


def shares(lineage: Pedigree, allele: Allele) -> np.ndarray:
    """Return the share of each organism's copies that are an allele.

    Parameters
    ----------
    lineage : Lineage
    allele : Allele

    Returns
    -------
    array of float64, shape (organisms,)
        0 to 1, or 0 and 1 for `copies` and `clade`; NaN for other species.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.lineage import Lineage
    >>> from ecs_eco.explain import Allele, shares
    >>> uid, none, zero = np.array([1, 2], np.uint64), np.zeros(2, np.uint64), np.zeros(2, int)
    >>> text, genomes = np.array(["AT", "AA"], object), {"rat": {"alphabet": "AT", "ploidy": 2, "genes": []}}
    >>> rats = Lineage(uid, none, none, np.full(2, "rat"), zero, zero, text, text, 5, 1.0, genomes)
    >>> shares(rats, Allele("rat", "letter", "", 0, "T")).tolist()
    [0.5, 0.0]
    """
    mask, out = lineage.species == allele.species, np.full(len(lineage), np.nan)
    out[mask] = Carried(lineage.of_species(allele.species), allele.species).share(allele)
    return out


def _path(site: Site, species: str, steps: Steps) -> tuple[Any, ...]:
    """Return the alleles of a site that are common enough for a test, with their columns of Paths."""
    samples, contributions = len(steps.ticks), steps.maternal if site.kind == "clade" else steps.both
    there = np.flatnonzero(steps.last > steps.first)
    came, went = steps.first[there], np.minimum(steps.last[there], samples)

    def living(of: Site) -> np.ndarray:
        one = np.ones(len(there))
        change = of.sums(came, one, samples + 1, there) - of.sums(went, one, samples + 1, there)
        return np.asarray(np.cumsum(change[:-1], axis=0))

    with np.errstate(divide="ignore", invalid="ignore"):
        n = np.where(steps.living > 0, steps.living, np.nan)[:, None]
        p = living(site) / n
        square = living(site.pairs()) / n if len(site.codes) > 1 else p
        number = n / site.weights if isinstance(site.weights, float) else n
        used = (p * number >= FEWEST - 1e-9) & ((1 - p) * number >= FEWEST - 1e-9)
    if site.kind in ("haplotype", "clade"):
        used &= np.logical_or.accumulate(p >= COMMON, axis=0)
    kept = np.asarray(used[:-1].any(axis=0))
    gain = site.sums(steps.step, contributions.excess, samples - 1, steps.organism)
    alleles = [Allele(species, site.kind, site.gene, site.locus, value) for value in site.values]
    chosen = [allele for allele, keep in zip(alleles, kept, strict=True) if keep]
    variance = np.maximum(square - p**2, 0)
    return chosen, p[:, kept], variance[:, kept], gain[:, kept], used[:-1, kept]


class Carried:
    """The alleles that the members of a species carry, read from their genomes when first asked for."""

    def __init__(self, own: Pedigree, species: str) -> None:
        self.own, self.species, self.kept = own, species, own.genomes.get(species, {})
        self.known: dict[tuple[Kind, str], Site] = {}

    @cached_property
    def matrix(self) -> np.ndarray:
        """Letters of genomes of equal length: see `_matrix`."""
        return _matrix(self.own.genome)

    def sites(self, steps: Steps) -> Iterator[Site]:
        """Yield all sites, with haplotypes and clades that may be common."""
        if self.kept and (self.own.genome != "").any():
            if self.kept.get("longest"):
                for gene in self.kept["genes"]:
                    yield from _limits(self.site("copies", gene["name"]))
            else:
                for locus in range(self.matrix.shape[1] // self.kept.get("ploidy", 1)):
                    yield from _letters(self.matrix, locus, self.kept)
            for gene in self.kept["genes"]:
                if has_few_values(gene):
                    yield self.site("value", gene["name"])
            yield _common(self.site("haplotype", ""), steps)
        yield _common(self.site("clade", ""), steps)

    def site(self, kind: Kind, gene: str) -> Site:
        """Return a site of any kind except a letter's."""
        if (kind, gene) not in self.known:
            self.known[kind, gene] = READERS[kind](self.own, self.species, gene)
        return self.known[kind, gene]

    def share(self, allele: Allele, rows: np.ndarray | slice = slice(None)) -> np.ndarray:
        """Return the share of copies of these organisms that are an allele: f64[rows]."""
        if allele.kind == "copies":
            number, (k, way) = self.site("copies", allele.gene).codes[0][rows], limit_of(allele.value)
            return np.asarray(number <= k if way == "fewer" else number >= k, np.float64)
        if allele.kind != "letter":
            return self.site(allele.kind, allele.gene).share(allele.value, rows)
        width = self.matrix.shape[1] // self.kept.get("ploidy", 1)
        return np.asarray((self.matrix[rows, allele.locus :: width] == ord(allele.value)).mean(axis=1))


def _matrix(genomes: np.ndarray) -> np.ndarray:
    """Return genomes of equal length as letters: u8[organisms, letters] or, if a letter is not ASCII,
    u32[organisms, letters]. A missing genome is 0."""
    text = pa.array(genomes, pa.large_string())
    width = pc.max(pc.utf8_length(text)).as_py() or 0
    data = np.frombuffer(text.buffers()[2] or b"", np.uint8)
    if data.size == len(genomes) * width:
        return data.reshape(len(genomes), width)
    return np.array(genomes.tolist(), f"U{width}").view(np.uint32).reshape(len(genomes), width)


def _letters(matrix: np.ndarray, locus: int, kept: dict[str, Any]) -> Iterator[Site]:
    """Yield the letters of a locus, unless all organisms have the same."""
    width = matrix.shape[1] // kept.get("ploidy", 1)
    columns = [np.ascontiguousarray(matrix[:, at]) for at in range(locus, matrix.shape[1], width)]
    most = max(int(column.max()) for column in columns) + 1
    counts = np.sum([np.bincount(column, minlength=most) for column in columns], axis=0)
    letters = np.flatnonzero(counts[1:]) + 1  # 0 is a missing genome
    if len(letters) > 1:
        code_of = np.full(len(counts), -1, np.int8)
        code_of[letters] = np.arange(len(letters))
        inside = [g["name"] for g in kept["genes"] if g["at"] <= locus < g["at"] + g["letters"]]
        codes, values = [code_of[column] for column in columns], tuple(map(chr, letters.tolist()))
        yield Site("letter", inside[0] if inside else "", locus, values, codes, 1 / len(codes))


def _of_values(own: Pedigree, species: str, gene: str) -> Site:
    """Return the values of a gene with few values."""
    names, codes = alleles_of(own, species, gene)
    codes = codes or [np.full(len(own), -1)]
    number = np.sum([of >= 0 for of in codes], axis=0)
    weights = 1 / len(codes) if (number == len(codes)).all() else 1 / np.maximum(number, 1)
    return Site("value", gene, gene_of(own, species, gene).get("at", -1), names, codes, weights)


def _copies(own: Pedigree, species: str, gene: str) -> Site:
    """Return the numbers of copies of a gene in variable-length genomes."""
    number = np.sum([of >= 0 for of in _of_values(own, species, gene).codes], axis=0)
    return Site("copies", gene, -1, tuple(str(k) for k in range(number.max() + 1)), [number], 1.0)


def _limits(copies: Site) -> Iterator[Site]:
    """Yield a site with the alleles "at most k copies" and "more copies" for each k."""
    for k in range(1, len(copies.values)):
        codes = [np.asarray(number >= k, np.int64) for number in copies.codes]
        yield replace(copies, values=(f"{k - 1} or fewer", f"{k} or more"), codes=codes)


def _haplotypes(own: Pedigree, species: str, _: str) -> Site:
    """Return whole strings."""
    kept, text = own.genomes[species], pa.array(own.genome, pa.large_string())
    ploidy = kept.get("ploidy", 1)
    if ploidy == 1:
        strings = [text]
    elif kept.get("longest"):
        halves = pc.split_pattern(text, kept["separator"])
        strings = [pc.list_element(halves, s) for s in range(ploidy)]
    else:
        width = (pc.max(pc.utf8_length(text)).as_py() or 0) // ploidy
        strings = [pc.utf8_slice_codeunits(text, s * width, (s + 1) * width) for s in range(ploidy)]
    known = pa.chunked_array(strings).combine_chunks().dictionary_encode()
    del text, strings  # as large as all genomes, each
    values = tuple(known.dictionary.to_pylist())
    codes = known.indices.to_numpy(zero_copy_only=False)
    if "" in values:  # a missing genome
        codes = np.where(codes == values.index(""), -1, codes)
    return Site("haplotype", "", -1, values, np.split(codes, ploidy), 1 / ploidy)


def _clades(own: Pedigree, *_: str) -> Site:
    """Return the clades of founders, through first parents."""
    line = np.where(own.mother >= 0, own.mother, own.father)
    root = np.where(line < 0, np.arange(len(own)), line)
    while not np.array_equal(root, up := root[root]):
        root = up
    founders, codes = np.unique(root, return_inverse=True)
    return Site("clade", "", -1, tuple(own.uid[founders].astype(str).tolist()), [codes], 1.0)


def _common(site: Site, steps: Steps) -> Site:
    """Return the alleles of a site that may reach 5% of the copies at a sample; the others have no code."""
    lived = np.maximum(np.minimum(steps.last, len(steps.ticks)) - steps.first, 0)
    seen = sum(np.bincount(codes + 1, lived, len(site.values) + 1)[1:] for codes in site.codes)
    least = COMMON * len(site.codes) * max(1, steps.living[steps.living > 0].min(initial=len(steps.first)))
    often = np.flatnonzero(seen >= least)
    new = np.full(len(site.values) + 1, -1)  # the last entry is for −1
    new[often] = np.arange(len(often))
    codes = [new[codes] for codes in site.codes]
    return replace(site, values=tuple(site.values[j] for j in often), codes=codes)


READERS: dict[Kind, Callable[[Pedigree, str, str], Site]] = {
    "value": _of_values,
    "copies": _copies,
    "haplotype": _haplotypes,
    "clade": _clades,
}
