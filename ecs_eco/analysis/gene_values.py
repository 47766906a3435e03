"""What the genomes of a record say of one gene: numbers from letters, as the layout of the species reads
them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from ecs_eco.analysis.carriers import codons_of, gene_of, words_of_strings
from ecs_eco.config.formula import compile_formula
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.genomes.traits import Kind, Trait

if TYPE_CHECKING:
    from ecs_eco.analysis.pedigree import Pedigree


def values_of(lineage: Pedigree, gene: str, species: str | None = None) -> np.ndarray:
    """What a gene, given by its name or its trait, says of each organism: f64[organisms], NaN for those
    without such a gene.

    With two strings, or several copies, it is the value that their dominance makes, as the organism has it.
    `species` is needed where several have a gene of that name. Raises KeyError for an unknown species or
    gene, ValueError for a gene of a whole network, and for records that do not say what codons mean.
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
    """The species that has a gene, named by itself or by its trait, and the gene's record; KeyError names the
    nearest, ValueError the species where several have it."""
    if species is not None:
        return species, gene_of(lineage, species, gene)
    having = {
        name: record
        for name, kept in lineage.genomes.items()
        for record in (*kept["genes"], *kept.get("derived", []))
        if gene in (record["name"], record["trait"])
    }
    if len(having) > 1:
        raise ValueError(
            f"gene {gene!r}: {', '.join(having)} have one of that name; say which: "
            f"species={next(iter(having))!r}"
        )
    if not having:
        known = [record["name"] for kept in lineage.genomes.values() for record in kept["genes"]]
        raise UnknownName(unknown_name("lineage", "gene", gene, known))
    return next(iter(having.items()))


def require_number(gene: dict[str, Any], species: str) -> None:
    """Raise ValueError for a gene whose value is no single number, or not known."""
    if "weights" in gene:
        raise ValueError(
            f"gene {gene['name']!r} of {species!r} codes for {gene['weights']:,} weights; "
            "allowed are genes of one number"
        )
    if not {"values", "range", "formula"} & gene.keys():
        raise ValueError(
            f"gene {gene['name']!r} of {species!r}: this record does not say what its codons "
            "mean; run the world again with this version, or count codons with frequencies()"
        )


def _of_formula(lineage: Pedigree, record: dict[str, Any], species: str) -> np.ndarray:
    kept = lineage.genomes[species]
    formulas = {one["name"]: one["formula"] for one in kept["derived"]}
    formula = compile_formula(record["formula"], [*(gene["name"] for gene in kept["genes"]), *formulas])
    out = formula(
        {
            name: _of_formula(lineage, {"formula": formulas[name]}, species)
            if name in formulas
            else values_of(lineage, name, species)
            for name in formula.names
        }
    )
    if "low" not in record:  # what another formula reads
        return out
    kind: Kind = "whole" if record.get("whole") else "number"
    default, low, high = (record[word] for word in ("default", "low", "high"))
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
    """What the copies in each string make together: f64[strings], NaN for no copy."""
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
    """What two alleles make."""
    how = gene.get("dominance", "first")
    if how == "mean":
        mean = (a + b) / 2
        return np.rint(mean) if gene.get("whole") else mean
    return np.maximum(a, b) if how == "greater" else a


def numbers(words: Sequence[str], gene: dict[str, Any], alphabet: str) -> np.ndarray:
    """What codons of a gene mean, f64[words]: a table of values, or a range in equal steps or factors.

    Raises ValueError for a letter that the alphabet lacks.
    """
    if not words:
        return np.zeros(0)
    letters = np.array(list(words), f"U{gene['letters']}").view("U1").reshape(len(words), gene["letters"])
    order = np.argsort(list(alphabet))
    place = np.minimum(np.searchsorted(np.array(list(alphabet))[order], letters), len(alphabet) - 1)
    digits = order[place]
    if (strange := np.array(list(alphabet))[digits] != letters).any():
        raise ValueError(f"gene {gene['name']!r}: the letter {letters[strange][0]!r} is none of {alphabet!r}")
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
    """Numbers of codons, the first letter being the most significant digit: i64[…, letters] to f64[…]."""
    return np.asarray(digits @ (float(size) ** np.arange(digits.shape[-1] - 1, -1, -1)))
