"""Count the carriers of each value of a gene over time from births and deaths, and draw them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, zip_longest
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from ecs_eco.analysis.palette import CLEAR, GREY
from ecs_eco.analysis.pedigree import Pedigree
from ecs_eco.analysis.style import DASHES, PALETTE, Axes, Figure, panels, styled
from ecs_eco.config.formula import compile_formula
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.genomes.promoters import copies_in
from ecs_eco.genomes.traits import Kind, Trait

FEW = 8  # maximum number of a gene's values that a figure can show


@dataclass(frozen=True)
class Frequencies:
    """The number of living organisms that carry each value of a gene: `count` i64[samples, values] at `ticks`
    i64[samples].

    `n` i64[samples] counts all living organisms. With several strings (ploidy 2) or several copies of a gene,
    an organism counts once for each value that it carries; an organism without the gene is not counted.
    `copies` i64[samples, values] counts strings, or copies of the gene, instead of organisms.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.carriers import Frequencies
    >>> count = np.array([[3, 1], [2, 2]])
    >>> red = Frequencies("red", np.array([0, 10]), ("0", "1"), count, np.array([4, 4]), count)
    >>> red.of("1").tolist(), red.share[:, 1].tolist()
    ([1, 2], [0.25, 0.5])
    """

    gene: str
    ticks: np.ndarray
    values: tuple[str, ...]
    count: np.ndarray
    n: np.ndarray
    copies: np.ndarray

    @property
    def share(self) -> np.ndarray:
        """Fraction of living organisms that carry each value, f64[samples, values]; NaN if none are alive."""
        return self.count / np.where(self.n, self.n, np.nan)[:, None]

    @property
    def allele(self) -> np.ndarray:
        """Allele frequency: the fraction of each value among a gene's copies, f64[samples, values], or NaN."""
        total = self.copies.sum(axis=1, keepdims=True)
        return self.copies / np.where(total, total, np.nan)

    def of(self, value: str) -> np.ndarray:
        """Return how many organisms carry a value.

        Parameters
        ----------
        value : str

        Returns
        -------
        array of int64, shape (samples,)

        Raises
        ------
        KeyError
            If the value is unknown.
        """
        if value not in self.values:
            raise UnknownName(unknown_name(f"gene {self.gene!r}", "value", value, self.values))
        return self.count[:, self.values.index(value)]


def frequencies(lineage: Pedigree, species: str, gene: str | Sequence[int], every: int) -> Frequencies:
    """Return how many living organisms carry each value of a gene, over time.

    Parameters
    ----------
    lineage : Lineage
    species : str
    gene : str or tuple of int
        Name of a gene in the manifest, or (first locus, number of letters).
    every : int
        Ticks between samples.

    Returns
    -------
    Frequencies
        Exact counts, from births and deaths. Values are in codon order; for a gene without a
        table of values, they are the codons themselves in alphabetical order.

    Raises
    ------
    KeyError
        If the species or gene is unknown.
    ValueError
        If loci are beyond the end of the genome, or the gene is a derived trait.
    """
    record, mask, ticks = gene_of(lineage, species, gene), lineage.species == species, lineage.samples(every)
    names, values = alleles_of(lineage, species, gene)
    count, copies = (np.zeros((len(ticks), len(names)), np.int64) for _ in range(2))
    has = np.zeros(len(lineage), np.int64)
    for j in range(len(names)):
        has[mask] = np.sum([v == j for v in values], axis=0) if values else 0
        count[:, j] = copies[:, j] = lineage.living_sums(ticks, mask=has > 0)
        if len(values) > 1:
            copies[:, j] = np.rint(lineage.living_sums(ticks, has.astype(float), mask))
    return Frequencies(record["name"], ticks, names, count, lineage.living_sums(ticks, mask=mask), copies)


def alleles_of(
    lineage: Pedigree, species: str, gene: str | Sequence[int]
) -> tuple[tuple[str, ...], list[np.ndarray]]:
    """Return the names of a gene's values and, for each possible copy, its value's index, i64[members], or −1."""
    record, kept = gene_of(lineage, species, gene), lineage.genomes.get(species, {})
    if "formula" in record:
        raise ValueError(f"gene {gene!r} of {species!r} is derived: no letters code for it")
    genomes = lineage.genome[lineage.species == species]
    codons = (
        _copies(genomes, record, kept)
        if kept.get("longest")
        else codons_of(genomes, record, species, kept.get("ploidy", 1))
    )
    return _values(codons, record, kept.get("alphabet", "ACGT"))


def gene_of(lineage: Pedigree, species: str, gene: str | Sequence[int]) -> dict[str, Any]:
    """Return the manifest's record of a gene, found by name, trait, or (first locus, number of letters)."""
    if species not in lineage.species:
        raise UnknownName(
            unknown_name("lineage", "species", species, dict.fromkeys(lineage.species.tolist()))
        )
    if not isinstance(gene, str):
        at, letters = gene
        if at < 0 or letters < 1:
            expected = "expected a first locus of 0 or more, and at least 1 letter"
            raise ValueError(f"gene {tuple(gene)} of {species!r}: {expected}")
        return {"name": f"{at}:{at + letters}", "at": at, "letters": letters}
    known = {g["name"]: g for g in genes_in(lineage.genomes.get(species, {}))}
    by_trait = {g["trait"]: g for g in known.values() if g["trait"]}
    if gene not in known and gene in by_trait:
        return by_trait[gene]
    if gene not in known:
        raise UnknownName(unknown_name(f"genome of {species!r}", "gene", gene, known))
    return known[gene]


def genes_in(kept: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the manifest's records of a species' genes and derived traits."""
    return [*kept.get("genes", ()), *kept.get("derived", ())]


def codons_of(
    genomes: np.ndarray, gene: dict[str, Any], species: str, strings: int
) -> list[tuple[list[str], np.ndarray]]:
    """Return, for each string of a genome, the distinct codons of a gene and the index of each organism's codon."""
    text = pa.array(genomes, pa.string())
    length = (pc.max(pc.utf8_length(text)).as_py() or 0) // strings
    if gene["at"] + gene["letters"] > length:
        place = f"loci {gene['at']} to {gene['at'] + gene['letters'] - 1}"
        raise ValueError(
            f"gene {gene['name']!r} is at {place}; a genome of {species!r} has {length} loci in the record"
        )
    cuts = []
    for at in range(gene["at"], strings * length, length):
        cut = pc.utf8_slice_codeunits(text, at, at + gene["letters"]).dictionary_encode()
        cuts.append((cut.dictionary.to_pylist(), cut.indices.to_numpy(zero_copy_only=False)))
    return cuts


def _copies(
    genomes: np.ndarray, gene: dict[str, Any], kept: dict[str, Any]
) -> list[tuple[list[str], np.ndarray]]:
    """Return the same for each possible copy of a gene in variable-length genomes; "" stands for no copy."""
    texts = pa.array(genomes, pa.string()).dictionary_encode()
    strings = words_of_strings(texts.dictionary.to_pylist(), gene, kept)
    copies = zip_longest(*(chain.from_iterable(of) for of in strings), fillvalue="")
    which = texts.indices.to_numpy(zero_copy_only=False)
    return [(list(words), which) for words in copies]


def words_of_strings(
    texts: Sequence[str], gene: dict[str, Any], kept: dict[str, Any]
) -> list[list[list[str]]]:
    """Return the letters after the promoter of each copy of a gene, by variable-length genome and string."""
    if "promoter" not in gene:
        raise ValueError(
            f"gene {gene['name']!r}: genes have no fixed position in variable-length strings; "
            "expected the name of a gene"
        )
    promoters = {g["name"]: g["promoter"] for g in kept["genes"]}
    spans = {g["name"]: len(g["promoter"]) + g["letters"] for g in kept["genes"]}
    skip, span = len(gene["promoter"]), spans[gene["name"]]

    def words(string: str) -> list[str]:
        places = (at for name, at in copies_in(string, promoters, spans) if name == gene["name"])
        return [string[at + skip : at + span] for at in places]

    return [[words(string) for string in text.split(kept["separator"])] for text in texts]


def _values(
    codons: list[tuple[list[str], np.ndarray]], gene: dict[str, Any], alphabet: str
) -> tuple[tuple[str, ...], list[np.ndarray]]:
    """Return the names of a gene's values and, for each string, the index of each organism's value."""
    words = sorted({word for cut, _ in codons for word in cut if word})
    if "values" in gene:
        distinct = list(dict.fromkeys(gene["values"]))
        names = [f"{v:g}" for v in distinct]
        meaning = {w: distinct.index(v) for w, v in zip(words, numbers(words, gene, alphabet), strict=True)}
    else:
        names, meaning = words, {w: i for i, w in enumerate(words)}
    return tuple(names), [np.array([meaning.get(w, -1) for w in cut])[which] for cut, which in codons]


def has_few_values(gene: dict[str, Any]) -> bool:
    """Return whether a figure can show the carriers of a gene: it must have two to eight values."""
    return 2 <= len(set(gene.get("values", ()))) <= FEW


def draw_values(
    genes: Sequence[Frequencies], title: str, label: str, high: float, alleles: bool = False
) -> tuple[Figure, Axes]:
    """Return a figure of the carriers of each value of genes after the first or, with `alleles`, of allele
    frequencies: of the second of two values, or of all. A gene named after a color is drawn in that color."""
    from matplotlib.colors import is_color_like

    figure, ((ax,),) = panels(1, 1, 9, high)
    rest, k = PALETTE[::-1], 0
    for g in genes:
        two = len(g.values) == 2
        for j in range(0 if alleles and len(g.values) > 2 else 1, len(g.values)):
            named = g.gene if two and is_color_like(g.gene) else rest[k % len(rest)]
            ax.plot(
                g.ticks,
                (g.allele if alleles else g.count)[:, j],
                color=CLEAR[g.gene][0] if g.gene in CLEAR else named,
                ls=DASHES[k % len(DASHES)],  # distinguish lines of similar color
                lw=1.7,
                label=g.gene if two and not alleles else f"{g.gene} = {g.values[j]}",
            )
            k += 1
    if genes:
        ax.set_xlim(genes[0].ticks[0], max(genes[0].ticks[-1], 1))
    ax.set(xlabel="tick", ylabel=label, title=title)
    return figure, ax


@styled
def carriers(genes: Sequence[Frequencies], title: str = "") -> Figure:
    """Plot the number of living carriers of each gene over time.

    Organisms with the value of the first codon do not count as carriers. A gene with more than two values has
    one line for each value after the first.

    Parameters
    ----------
    genes : sequence of Frequencies
    title : str, default ""

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.analysis.carriers import Frequencies, carriers
    >>> count = np.array([[3, 1], [2, 2]])
    >>> red = Frequencies("red", np.array([0, 10]), ("0", "1"), count, np.array([4, 4]), count)
    >>> carriers([red]).axes[0].get_ylabel()
    'number of carriers'
    """
    figure, ax = draw_values(genes, title, "number of carriers", 3.6)
    if genes:
        ax.plot(genes[0].ticks, genes[0].n, color=GREY, lw=1, zorder=1.5, label="all")
    ax.set_ylim(0, None)
    figure.legend(loc="outside upper left", ncols=6)
    return figure


def values_of(lineage: Pedigree, gene: str, species: str | None = None) -> np.ndarray:
    """Return the value of a gene for each organism.

    Parameters
    ----------
    lineage : Lineage
    gene : str
        The gene's name or trait.
    species : str, optional
        Required if several species have a gene with that name.

    Returns
    -------
    array of float64, shape (organisms,)
        Values after dominance; NaN for organisms without this gene.

    Raises
    ------
    KeyError
        If the species or gene is unknown.
    ValueError
        If the gene codes for a whole network, or the record does not define the meaning of codons.
    """
    name, record = find_gene(lineage, gene, species)
    kept, mask = lineage.genomes[name], lineage.species == name
    require_number(record, name)
    out = np.full(len(lineage), np.nan)
    if mask.any() and "formula" in record:
        out[mask] = _of_formula(lineage, record, name)[mask]
    elif mask.any():
        read = _of_variable if kept.get("longest") else _of_fixed
        out[mask] = read(lineage.genome[mask], record, kept, name)
    return out


def find_gene(lineage: Pedigree, gene: str, species: str | None = None) -> tuple[str, dict[str, Any]]:
    """Return the species that has a gene (named, or by its trait), and the record; raise ValueError for several."""
    if species is not None:
        return species, gene_of(lineage, species, gene)
    having = {
        name: record
        for name, kept in lineage.genomes.items()
        for record in genes_in(kept)
        if gene in (record["name"], record["trait"])
    }
    if len(having) > 1:
        raise ValueError(
            f"gene {gene!r}: {', '.join(having)} have a gene with that name; choose one: "
            f"species={next(iter(having))!r}"
        )
    if not having:
        known = [record["name"] for kept in lineage.genomes.values() for record in kept["genes"]]
        raise UnknownName(unknown_name("lineage", "gene", gene, known))
    return next(iter(having.items()))


def require_number(gene: dict[str, Any], species: str) -> None:
    """Raise ValueError if a gene's value is unknown or is not a single number."""
    if "weights" in gene:
        raise ValueError(
            f"gene {gene['name']!r} of {species!r} codes for {gene['weights']:,} weights; "
            "expected a gene that codes for one number"
        )
    if not {"values", "range", "formula"} & gene.keys():
        raise ValueError(
            f"gene {gene['name']!r} of {species!r}: this record does not define what its "
            "codons mean; run the world again with this version, or count codons with frequencies()"
        )


def _of_formula(lineage: Pedigree, record: dict[str, Any], species: str) -> np.ndarray:
    kept = lineage.genomes[species]
    formulas = {one["name"]: one["formula"] for one in kept["derived"]}
    formula = compile_formula(record["formula"], [*(gene["name"] for gene in kept["genes"]), *formulas])

    def value(name: str) -> np.ndarray:
        if name not in formulas:
            return values_of(lineage, name, species)
        return _of_formula(lineage, {"formula": formulas[name]}, species)

    out = formula({name: value(name) for name in formula.names})
    if "low" not in record:  # used only by another formula
        return out
    kind: Kind = "whole" if record.get("whole") else "number"
    default, low, high = (float(record[word]) for word in ("default", "low", "high"))
    return Trait(record["trait"], "", "", None, default, low, high, kind, "", "").nearest(out)


def _of_fixed(genomes: np.ndarray, gene: dict[str, Any], kept: dict[str, Any], species: str) -> np.ndarray:
    strings = [
        numbers(words, gene, kept["alphabet"])[which]
        for words, which in codons_of(genomes, gene, species, kept.get("ploidy", 1))
    ]
    return strings[0] if len(strings) == 1 else _dominated(strings[0], strings[1], gene)


def _of_variable(genomes: np.ndarray, gene: dict[str, Any], kept: dict[str, Any], _: str) -> np.ndarray:
    texts = pa.array(genomes, pa.string()).dictionary_encode()
    by_string = words_of_strings(texts.dictionary.to_pylist(), gene, kept)
    strings = [_together([words[s] for words in by_string], gene, kept) for s in range(kept.get("ploidy", 1))]
    if len(strings) == 1:
        out = strings[0]
    else:
        a, b = strings
        out = np.where(np.isnan(b), a, np.where(np.isnan(a), b, _dominated(a, b, gene)))
    out = np.where(np.isnan(out), gene["without"], out)
    return (np.rint(out) if gene.get("whole") else out)[texts.indices.to_numpy(zero_copy_only=False)]


def _together(copies: Sequence[Sequence[str]], gene: dict[str, Any], kept: dict[str, Any]) -> np.ndarray:
    """Return the combined value of the copies in each string: f64[strings], NaN without copies."""
    words = sorted({word for string in copies for word in string})
    meaning = dict(zip(words, numbers(words, gene, kept["alphabet"]).tolist(), strict=True))
    rules: dict[str, Callable[[list[float]], float]] = {
        "first": lambda v: v[0],
        "mean": lambda v: sum(v) / len(v),
        "greatest": max,
        "sum": sum,
    }
    how = rules[gene["doubled"]]
    out = np.array([how([meaning[w] for w in string]) if string else np.nan for string in copies], float)
    if gene["doubled"] == "sum":
        limits = gene.get("values") or [gene["range"]["low"], gene["range"]["high"]]
        out = np.clip(out, min(limits), max(limits))
    return out


def _dominated(a: np.ndarray, b: np.ndarray, gene: dict[str, Any]) -> np.ndarray:
    """Return the combined value of two alleles under dominance."""
    how = gene.get("dominance", "first")
    if how == "mean":
        mean = (a + b) / 2
        return np.rint(mean) if gene.get("whole") else mean
    return np.maximum(a, b) if how == "greater" else a


def numbers(words: Sequence[str], gene: dict[str, Any], alphabet: str) -> np.ndarray:
    """Return the values of a gene's codons, f64[words]: from a table, or a range divided into equal steps or
    factors. Raises ValueError if a letter is not in the alphabet."""
    if not words:
        return np.zeros(0)
    if strange := [letter for letter in "".join(words) if letter not in alphabet]:
        raise ValueError(f"gene {gene['name']!r}: the letter {strange[0]!r} is not in {alphabet!r}")
    digits = np.array([[alphabet.index(letter) for letter in word] for word in words])
    if "values" in gene:
        return np.array(gene["values"], float)[_number(digits, len(alphabet)).astype(np.int64)]
    span = gene["range"]
    digits = digits.reshape(len(words), span["codons"], -1)
    if span["code"] == "gray":
        digits = np.cumsum(digits, axis=2) % len(alphabet)
    levels = len(alphabet) ** digits.shape[2]
    share = _number(digits, len(alphabet)).sum(axis=1) / (span["codons"] * (levels - 1))
    low, high = span["low"], span["high"]
    if span["scale"] == "log":
        return np.clip(low * (high / low) ** share, low, high)
    out = np.clip(low + (high - low) * share, low, high)
    return np.rint(out) if gene.get("whole") else out


def _number(digits: np.ndarray, size: int) -> np.ndarray:
    """Convert codons to numbers, most significant letter first: i64[…, letters] to f64[…]."""
    return np.asarray(digits @ (float(size) ** np.arange(digits.shape[-1] - 1, -1, -1)))
