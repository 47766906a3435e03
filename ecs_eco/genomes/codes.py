"""The code of a gene: its codons represent table entries, numbers in a range, or the weights of a network.

A codon of k letters from an alphabet of A letters is a number from 0 to A^k − 1; its first letter is the most
significant digit. In Gray code, a digit is the sum of all letters up to it modulo A, so adjacent numbers
differ in one letter.
"""

import math

import numpy as np

from ecs_eco.compiled.elementary import arrays, power, scalars
from ecs_eco.genomes.later import kernels
from ecs_eco.genomes.models import Gene
from ecs_eco.genomes.traits import Shapes, Trait

SLACK = 1e-6  # how far float32 can round beyond the end of a range, relative to its size


class Codons:
    """The positions of a gene's codons, and how their letters form numbers."""

    def __init__(self, gene: Gene, first: int, n: int, size: int) -> None:
        self.gene, self.first, self.n, self.size = gene, first, n, size
        self.levels = size**gene.letters
        self.length = n * gene.letters

    def read(self, loci: np.ndarray, start: int) -> np.ndarray:
        """Return the numbers i64[n, codons] coded by u8[n, loci] in the string that begins at `start`."""
        out = np.empty((len(loci), self.n), np.int64)
        kernels.read_codons(
            loci, start + self.first, self.gene.letters, self.size, self.gene.code == "gray", out
        )
        return out

    def write(self, numbers: np.ndarray, loci: np.ndarray, start: int) -> None:
        """Write numbers i64[n, codons] to u8[n, loci]."""
        kernels.write_codons(
            numbers, start + self.first, self.gene.letters, self.size, self.gene.code == "gray", loci
        )


class Code:
    """The base class of codes; `trait` is the gene's trait, None for a neutral marker or an unknown trait."""

    dtype: type = np.float32
    width: tuple[int, ...] = ()  # the shape of one organism's value
    resolution = 0.0  # largest distance between adjacent values
    low, high = 0.0, 0.0

    def __init__(self, gene: Gene, trait: Trait | None, codons: Codons) -> None:
        self.gene, self.trait, self.codons = gene, trait, codons
        self.name, self.first, self.stop = gene.name, codons.first, codons.first + codons.length

    @property
    def text(self) -> str:
        """A short description of the code."""
        raise NotImplementedError

    def values(self, numbers: np.ndarray) -> np.ndarray:
        """Return the values f64[n, …] of codons with numbers i64[n, codons]."""
        raise NotImplementedError

    def numbers(self, values: np.ndarray, clip: bool) -> np.ndarray:
        """Return numbers i64[n, codons] for values f64[n, …], or for the nearest valid ones with `clip`."""
        raise NotImplementedError

    def refuse(self, value: float, allowed: str) -> ValueError:
        """Return the error for a value that no codon represents."""
        return ValueError(f"gene {self.name!r}: no codon codes for {value:g}; expected {allowed}")


class Listed(Code):
    """One value per codon."""

    def __init__(self, gene: Gene, trait: Trait | None, codons: Codons) -> None:
        super().__init__(gene, trait, codons)
        self.meaning = np.array(gene.values, np.float64)
        self.known, self.codon_of = np.unique(self.meaning, return_index=True)
        self.low, self.high = float(self.known[0]), float(self.known[-1])
        if is_whole(gene, trait):
            self.dtype = np.int32

    @property
    def text(self) -> str:
        return f"one of {', '.join(f'{v:g}' for v in self.known[:6])}{', …' if self.known.size > 6 else ''}"

    def values(self, numbers: np.ndarray) -> np.ndarray:
        return self.meaning[numbers[:, 0]]

    def numbers(self, values: np.ndarray, clip: bool) -> np.ndarray:
        after = np.clip(np.searchsorted(self.known, values), 1, max(self.known.size - 1, 1))
        before = after - 1
        after = np.minimum(after, self.known.size - 1)
        nearest = np.where(values - self.known[before] <= self.known[after] - values, before, after)
        off = np.abs(self.known[nearest] - values) > SLACK * np.maximum(np.abs(values), 1.0)
        if not clip and off.any():
            raise self.refuse(values[off][0], ", ".join(f"{v:g}" for v in self.known[:20]))
        return self.codon_of[nearest].astype(np.int64)[:, None]


class Range(Code):
    """A number from low to high, in equal steps or, on a logarithmic scale, by equal factors."""

    def __init__(self, gene: Gene, trait: Trait | None, codons: Codons) -> None:
        super().__init__(gene, trait, codons)
        self.low, self.high = float(gene.low or 0.0), float(gene.high or 0.0)
        self.steps = codons.n * (codons.levels - 1)
        self.whole = is_whole(gene, trait)
        self.log = gene.scale == "log"
        self.resolution = (self.high - self.low) / self.steps
        if self.log:
            self.resolution = self.high * -scalars.expm1(-scalars.log(self.high / self.low) / self.steps)
        if self.whole:
            self.dtype, self.resolution = np.int32, float(math.ceil(self.resolution - SLACK))

    @property
    def text(self) -> str:
        scale = ", log" if self.log else ""
        adds = f", {self.codons.n} codons" if self.gene.code == "additive" else ""
        return f"{self.low:g} to {self.high:g} ({self.gene.code}{adds}{scale})"

    def values(self, numbers: np.ndarray) -> np.ndarray:
        share = numbers.sum(axis=1) / self.steps
        if self.log:
            return np.clip(self.low * power(self.high / self.low, share), self.low, self.high)
        out = np.clip(self.low + (self.high - self.low) * share, self.low, self.high)
        return np.rint(out) if self.whole else out

    def numbers(self, values: np.ndarray, clip: bool) -> np.ndarray:
        slack = SLACK * max(abs(self.low), abs(self.high))
        outside = ~((values >= self.low - slack) & (values <= self.high + slack))
        if not clip and outside.any():
            raise self.refuse(values[outside][0], f"{self.low:g} to {self.high:g}")
        values = np.clip(values, self.low, self.high)
        share = (values - self.low) / (self.high - self.low)
        if self.log:
            share = arrays.log(values / self.low) / arrays.log(self.high / self.low)
        total = np.rint(share * self.steps).astype(np.int64)
        if self.log:  # the value with the nearest logarithm need not be the nearest value
            ratio = self.high / self.low
            low = np.clip(np.floor(share * self.steps), 0, self.steps - 1)
            below, above = (self.low * power(ratio, n / self.steps) for n in (low, low + 1))
            total = (low + (above - values < values - below)).astype(np.int64)
        n = self.codons.n
        return total[:, None] // n + (np.arange(n) < total[:, None] % n)


class Weights(Code):
    """All weights of a network in one vector: one codon per weight, or coefficients of a cosine transform.

    With form "direct", range and resolution apply to weights. With "cosine", a matrix (a, b) is a sum of
    low-frequency basis functions times their coefficients (Koutník, Gomez & Schmidhuber 2010). The basis
    functions come from the orthonormal two-dimensional discrete cosine transform of type II, ordered by the
    sum of the two frequencies; for a bias vector, the transform is one-dimensional. Range and resolution then
    apply to the coefficients, and encoding drops the higher frequencies.
    """

    def __init__(self, gene: Gene, trait: Trait | None, codons: Codons, shapes: Shapes) -> None:
        super().__init__(gene, trait, codons)
        self.low, self.high = float(gene.low or 0.0), float(gene.high or 0.0)
        self.resolution = (self.high - self.low) / (codons.levels - 1)
        self.shapes = [tuple(shape) for shape in shapes]
        self.width = (sum(math.prod(shape) for shape in self.shapes),)
        self.bases: list[np.ndarray] | None = None
        if gene.form == "cosine":
            self.bases = [cosines(shape, gene.coefficients or 1) for shape in self.shapes]

    @property
    def text(self) -> str:
        noun = "weights" if self.bases is None else f"coefficients of {self.width[0]} weights"
        return f"{self.codons.n} {noun}, {self.low:g} to {self.high:g} ({self.gene.code})"

    def values(self, numbers: np.ndarray) -> np.ndarray:
        if self.bases is None:
            return self._numbers_to_range(numbers)
        out, at, begin = np.empty((len(numbers), *self.width)), 0, 0
        for basis in self.bases:
            k, size = basis.shape
            part = np.empty((len(numbers), size))
            kernels.combine(self._numbers_to_range(numbers[:, at : at + k]), basis, part)
            out[:, begin : begin + size] = part
            at, begin = at + k, begin + size
        return out

    def numbers(self, values: np.ndarray, clip: bool) -> np.ndarray:
        slack = SLACK * max(abs(self.low), abs(self.high))
        if self.bases is not None:
            parts, begin = [], 0
            for basis in self.bases:
                part = values[:, begin : begin + basis.shape[1]]
                # not @, because the last bits of BLAS results depend on its threads
                parts.append(np.einsum("nw,kw->nk", part, basis))
                begin += basis.shape[1]
            values, slack = np.concatenate(parts, axis=1), max(slack, self.resolution / 2)
        outside = ~((values >= self.low - slack) & (values <= self.high + slack))
        if not clip and outside.any():
            noun = "weights" if self.bases is None else "coefficients"
            raise self.refuse(values[outside][0], f"{noun} from {self.low:g} to {self.high:g}")
        steps = self.codons.levels - 1
        share = (np.clip(values, self.low, self.high) - self.low) / (self.high - self.low)
        return np.rint(share * steps).astype(np.int64)

    def _numbers_to_range(self, numbers: np.ndarray) -> np.ndarray:
        return self.low + (self.high - self.low) * (numbers / (self.codons.levels - 1))


def is_whole(gene: Gene, trait: Trait | None) -> bool:
    """Return whether a gene's values are integers."""
    return gene.whole or (trait is not None and trait.kind in ("whole", "sign"))


def cosines(shape: tuple[int, ...], most: int) -> np.ndarray:
    """Return the first `most` functions of the orthonormal cosine transform over a shape: f64[k, size]."""
    a, b = shape if len(shape) == 2 else (1, shape[0])
    pairs = sorted((i + j, i, j) for i in range(a) for j in range(b) if i + j <= most)[:most]
    return np.array([np.outer(_cosine(i, a), _cosine(j, b)).ravel() for _, i, j in pairs])


def _cosine(frequency: int, n: int) -> np.ndarray:
    scale = math.sqrt((1.0 if frequency == 0 else 2.0) / n)
    return scale * arrays.cos(math.pi * (np.arange(n) + 0.5) * frequency / n)
