"""Whether the layout of a genome can be lived with."""

import numpy as np

from ecs_eco.genomes.codes import Code, Range, Weights
from ecs_eco.genomes.layout import Layout

SAMPLES = 2000


def check_genome(layout: Layout, n: int = SAMPLES) -> None:
    """Check a layout on `n` random genomes: all say finite values in bounds, each row alone the same as among others, and
    what a string says, encoded and decoded again, stays; the text of a genome is cut into its genes without a rest.
    """
    loci = layout.random(np.arange(n, dtype=np.uint64))
    values = layout.decode(loci)
    first = {code.name: layout.alleles(loci, code.name)[:, 0] for code in layout.genes}
    again = layout.decode(layout.encode(first, clip=True))
    order = np.argsort(loci[:, 0], kind="stable")[::-1]
    turned, alone = layout.decode(loci[order]), layout.decode(loci[:1])
    for code in layout.genes:
        where, found = f"gene {code.name!r}", values[code.name]
        if found.shape != (n, *code.width) or not np.isfinite(found).all():
            raise AssertionError(f"{where}: random genomes say values of the shape {found.shape}, not all finite")
        if not (np.array_equal(turned[code.name], found[order]) and np.array_equal(alone[code.name], found[:1])):
            raise AssertionError(f"{where}: what a genome says depends on the others that are decoded with it")
        _check_bounds(where, code, found)
        _check_again(where, code, first[code.name], again[code.name])
    text = layout.alphabet.decode(loci[0])
    if "".join(piece.letters for piece in layout.mark(text)) != text or not np.array_equal(layout.alphabet.encode(text), loci[0]):
        raise AssertionError(f"the text {text[:40]!r} is not the sum of its pieces")


def _check_bounds(where: str, code: Code, found: np.ndarray) -> None:
    low, high = code.low, code.high
    if isinstance(code, Weights) and code.bases is not None:
        return
    slack = 1e-6 * max(abs(low), abs(high))
    if (found < low - slack).any() or (found > high + slack).any():
        raise AssertionError(f"{where}: random genomes say {found.min():g} to {found.max():g}, beyond {low:g} to {high:g}")


def _check_again(where: str, code: Code, found: np.ndarray, again: np.ndarray) -> None:
    slack = 0.0
    if isinstance(code, Range | Weights) and code.dtype is np.float32:
        slack = 1e-5 * max(abs(code.low), abs(code.high))
    if (np.abs(found.astype(np.float64) - again) > slack).any():
        row = np.abs(found.astype(np.float64) - again).reshape(len(found), -1).max(axis=1).argmax()
        raise AssertionError(f"{where}: {found[row]} encoded and decoded again is {again[row]}")
