"""Genomes as the text that records hold."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components.genome import Genome

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


def texts_of(table: "Table", rows: np.ndarray, letters: np.ndarray) -> np.ndarray:
    """Return the genomes of rows i64[k] as text: bytes[k], or str[k] where a letter is none of ASCII; ""
    without a genome. `letters` are `letters_of(table)`."""
    if Genome not in table or not table[Genome].loci.shape[1]:
        return np.zeros(rows.size, "S1")
    loci = table[Genome].loci[rows]
    if (joined := getattr(getattr(table.species.heredity, "layout", None), "joined", None)) is not None:
        loci = joined(loci)  # strings of variable length without what is behind their ends
    text = letters[loci]
    return text.view(f"{text.dtype.kind}{text.shape[1]}")[:, 0]


def letters_of(table: "Table") -> np.ndarray:
    """Return the letter of each number in a table's genomes: "S1"[256], "U1"[256] beyond ASCII;
    "?" where there is none. Strings of variable length end with "", and have a separator."""
    from ecs_eco.genomes import DNA

    layout: Any = getattr(table.species.heredity, "layout", None)
    alphabet: Any = getattr(layout, "alphabet", DNA)
    letters = getattr(alphabet, "letters", alphabet)
    if (separator := getattr(layout, "separator", None)) is not None:
        letters += "\0" + separator
    letters = letters.ljust(256, "?")
    return np.array(list(letters), "S1" if letters.isascii() else "U1")
