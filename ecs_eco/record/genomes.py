"""Genomes as text for records, and the description of their genes for a manifest."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Genome
from ecs_eco.genomes.alphabet import DNA
from ecs_eco.genomes.codes import Code

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


def texts_of(table: "Table", rows: np.ndarray, letters: np.ndarray) -> np.ndarray:
    """Return the genomes of rows i64[k] as text: bytes[k], or str[k] if a letter is not ASCII; "" if there is
    no genome. `letters` is the result of `letters_of(table)`."""
    if not has_text(table):
        return np.zeros(rows.size, "S1")
    loci = table[Genome].loci[rows]
    if (joined := getattr(getattr(table.species.heredity, "layout", None), "joined", None)) is not None:
        loci = joined(loci)  # strings of variable length, without the unused ends
    text = letters[loci]
    return text.view(f"{text.dtype.kind}{text.shape[1]}")[:, 0]


def has_text(table: "Table") -> bool:
    """Return whether the genomes of a table's members can be written as text."""
    return Genome in table and table[Genome].loci.shape[1] > 0


def letters_of(table: "Table") -> np.ndarray:
    """Return the letter for each number in a table's genomes: "S1"[256], or "U1"[256] if a letter is not
    ASCII; "?" for undefined numbers. Strings of variable length end with "" and have a separator."""
    layout: Any = getattr(table.species.heredity, "layout", None)
    alphabet: Any = getattr(layout, "alphabet", DNA)
    letters = getattr(alphabet, "letters", alphabet)
    if (separator := getattr(layout, "separator", None)) is not None:
        letters += "\0" + separator
    letters = letters.ljust(256, "?")
    return np.array(list(letters), "S1" if letters.isascii() else "U1")


def genes_of(table: "Table") -> dict[str, Any] | None:
    """Describe a species' genome: alphabet, strings (ploidy), genes; return None if it has no genome.

    A gene has a name, its first locus `at`, the number of `letters`, a `trait` (null for a neutral marker)
    and one of the following: `values`, one for each codon in order; the numeric `range` of its codons; or the
    number of `weights` in a network. It has `dominance` if there are two strings, and `whole` if its values
    are integers. `derived` traits, if any, have a `formula` over genes and the limits `low` and `high`. If
    strings vary in length, a gene has no position but a `promoter` that precedes its letters, the rule
    `doubled` for several copies, and the value `without` any copy; the genome has `longest` and the
    `separator` between two strings.
    """
    layout: Any = getattr(table.species.heredity, "layout", None)
    if layout is None:
        return None
    genes = [
        {
            "name": code.name,
            "at": int(code.first),
            "letters": int(code.stop - code.first),
            "trait": code.gene.trait,
            **_meaning(code),
            **({"dominance": code.gene.expression or layout.expression} if layout.ploidy > 1 else {}),
        }
        for code in layout.genes
    ]
    out = {"alphabet": layout.alphabet.letters, "ploidy": int(layout.ploidy), "genes": genes}
    if layout.longest is not None:
        for gene, code in zip(genes, layout.genes, strict=True):
            del gene["at"]
            gene |= {
                "promoter": layout.promoters[gene["name"]],
                "doubled": code.gene.copy_rule or layout.doubled,
                "without": layout.own_value(code),
            }
        out |= {"longest": layout.longest, "separator": layout.separator}
    if derived := getattr(table.species.heredity, "derived", None):
        out["derived"] = [
            {
                "name": name,
                "formula": formula.text,
                "trait": trait.name,
                "low": trait.low,
                "high": trait.high,
                "default": trait.default,
                **({"whole": True} if trait.kind in ("whole", "sign") else {}),
            }
            for name, (formula, trait) in derived.items()
        ]
    return out


def _meaning(code: Code) -> dict[str, Any]:
    """Return the meaning of a gene's codons."""
    gene, whole = code.gene, {"whole": True} if code.dtype is np.int32 else {}
    if gene.values is not None:
        return {"values": [float(v) for v in gene.values], **whole}
    if code.width:
        return {"weights": int(code.width[0])}
    return {
        "range": {
            "low": code.low,
            "high": code.high,
            "code": gene.code,
            "scale": gene.scale,
            "codons": int(code.codons.n),
        },
        **whole,
    }
