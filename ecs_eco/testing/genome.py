"""Conformance check for a genome's layout."""

import numpy as np

from ecs_eco.genomes.codes import Code, Range, Weights
from ecs_eco.genomes.layout import Layout

SAMPLES = 2000


def check_genome(layout: Layout, n: int = SAMPLES) -> None:
    """Check a layout with random genomes.

    All genomes must decode to finite values within bounds; a row must decode to the same values alone and in
    a batch; values must survive encoding and decoding; and a genome's text must consist of its parts.

    Parameters
    ----------
    layout : Layout
    n : int
        Number of genomes.

    Raises
    ------
    AssertionError
        If a check fails.

    Examples
    --------
    >>> from ecs_eco.genomes import Gene, Layout
    >>> from ecs_eco.testing import check_genome
    >>> check_genome(Layout([Gene(name="size", trait="size", letters=4, low=0.2, high=0.6)]))
    """
    loci = layout.random(np.arange(n, dtype=np.uint64))
    values = layout.decode(loci)
    first = {code.name: layout.alleles(loci, code.name)[:, 0] for code in layout.genes}
    decoded_again = layout.decode(layout.encode(first, clip=True))
    order = np.argsort(loci[:, 0], kind="stable")[::-1]
    turned, alone = layout.decode(loci[order]), layout.decode(loci[:1])
    for code in layout.genes:
        where, decoded = f"gene {code.name!r}", values[code.name]
        if decoded.shape != (n, *code.width) or not np.isfinite(decoded).all():
            raise AssertionError(
                f"{where}: random genomes code for values of shape {decoded.shape}, which are not all finite"
            )
        pairs = (turned[code.name], decoded[order]), (alone[code.name], decoded[:1])
        if not all(np.array_equal(*pair) for pair in pairs):
            raise AssertionError(f"{where}: the values of a genome depend on the other genomes in the batch")
        _check_bounds(where, code, decoded)
        if layout.longest is None or (code.gene.copy_rule or layout.doubled) in ("first", "greatest"):
            _check_again(
                where, code, first[code.name], decoded_again[code.name]
            )  # except the combined values of several copies
    text = layout.text(loci[0])
    letters = text.replace(getattr(layout, "separator", "\n"), "")
    if "".join(piece.letters for piece in layout.mark(text)) != letters or not np.array_equal(
        layout.rows([text])[0], loci[0]
    ):
        raise AssertionError(f"the text {text[:40]!r} does not consist of its pieces")


def _check_bounds(where: str, code: Code, decoded: np.ndarray) -> None:
    low, high = code.low, code.high
    if isinstance(code, Weights) and code.bases is not None:
        return
    slack = 1e-6 * max(abs(low), abs(high))
    if (decoded < low - slack).any() or (decoded > high + slack).any():
        raise AssertionError(
            f"{where}: random genomes code for {decoded.min():g} to {decoded.max():g}, "
            f"beyond {low:g} to {high:g}"
        )


def _check_again(where: str, code: Code, decoded: np.ndarray, decoded_again: np.ndarray) -> None:
    slack = 0.0
    if isinstance(code, Range | Weights) and code.dtype is np.float32:
        slack = 1e-5 * max(abs(code.low), abs(code.high))
    off = np.abs(decoded.astype(np.float64) - decoded_again)
    if (off > slack).any():
        row = off.reshape(len(off), -1).max(axis=1).argmax()
        raise AssertionError(f"{where}: encoding and decoding changes {decoded[row]} to {decoded_again[row]}")
