"""Matrix products and random orthogonal matrices of the portable mode: sums in one order everywhere.

Libraries choose that order by the processor. Here sums go along contiguous memory in fixed groups, so that
they become vectors of any width without another result. `addmm`, `mm` and `row_sums` take torch's tensors and
stand in the places of its functions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.engine.elementary import arrays
from ecs_eco.engine.jit import njit


def addmm(bias: Any, a: Any, b: Any, *, out: Any) -> None:
    """Write out [n, m] = bias [m] or [n, 1] + a [n, k] @ b [k, m]."""
    bias, a, b, out = bias.numpy(), a.numpy(), b.numpy(), out.numpy()
    if b.flags.c_contiguous:
        out[...] = bias
        _add_rows(a, b, out)
    else:  # a head's: b is a transposed matrix of rows
        out[...] = bias
        _add_dots(a, b.T, out)


def mm(a: Any, b: Any, *, out: Any) -> None:
    """Write out [n, m] = a [n, k] @ b [k, m]."""
    a, b, out = a.numpy(), b.numpy(), out.numpy()
    out[...] = 0
    if len(a) <= a.shape[1]:  # few results of long sums
        _add_outer(a.T, b, out)
    else:
        _add_rows(a, np.ascontiguousarray(b), out)


def row_sums(a: Any, *, out: Any) -> None:
    """Write out [n, 1], the sums of the rows of a [n, k]."""
    _sum_rows(a.numpy(), out.numpy())


@njit
def _add_rows(a, b, out):
    """Add a @ b to out, row by row: four rows of b at a time."""
    k = a.shape[1]
    full = k // 4 * 4
    for i in range(a.shape[0]):
        to = out[i]
        for j in range(0, full, 4):
            a0, a1, a2, a3 = a[i, j], a[i, j + 1], a[i, j + 2], a[i, j + 3]
            b0, b1, b2, b3 = b[j], b[j + 1], b[j + 2], b[j + 3]
            for c in range(len(to)):
                to[c] += (a0 * b0[c] + a1 * b1[c]) + (a2 * b2[c] + a3 * b3[c])
        for j in range(full, k):
            a0, b0 = a[i, j], b[j]
            for c in range(len(to)):
                to[c] += a0 * b0[c]


@njit
def _add_outer(a, b, out):
    """Add a.T @ b to out: four rows of both at a time."""
    n, full = a.shape[0], a.shape[0] // 4 * 4
    for i in range(0, full, 4):
        b0, b1, b2, b3 = b[i], b[i + 1], b[i + 2], b[i + 3]
        for k in range(a.shape[1]):
            a0, a1, a2, a3, to = a[i, k], a[i + 1, k], a[i + 2, k], a[i + 3, k], out[k]
            for c in range(len(to)):
                to[c] += (a0 * b0[c] + a1 * b1[c]) + (a2 * b2[c] + a3 * b3[c])
    for i in range(full, n):
        b0 = b[i]
        for k in range(a.shape[1]):
            a0, to = a[i, k], out[k]
            for c in range(len(to)):
                to[c] += a0 * b0[c]


@njit
def _add_dots(a, b, out):
    """Add a @ b.T to out: each a sum of eight partial sums."""
    k = a.shape[1]
    full, part = k // 8 * 8, np.zeros(8, np.float32)
    for i in range(b.shape[0]):
        there = b[i]
        for o in range(a.shape[0]):
            here, rest = a[o], np.float32(0)
            part[:] = 0
            for j in range(0, full, 8):
                for lane in range(8):
                    part[lane] += here[j + lane] * there[j + lane]
            for j in range(full, k):
                rest += here[j] * there[j]
            out[o, i] += ((part[0] + part[1]) + (part[2] + part[3])) + (
                (part[4] + part[5]) + (part[6] + part[7])) + rest


@njit
def _sum_rows(a, out):
    """Write the sums of rows, each of eight partial sums."""
    full, part = a.shape[1] // 8 * 8, np.zeros(8, np.float32)
    for i in range(a.shape[0]):
        here, rest = a[i], np.float32(0)
        part[:] = 0
        for j in range(0, full, 8):
            for lane in range(8):
                part[lane] += here[j + lane]
        for j in range(full, a.shape[1]):
            rest += here[j]
        out[i, 0] = ((part[0] + part[1]) + (part[2] + part[3])) + (
            (part[4] + part[5]) + (part[6] + part[7])) + rest


def orthogonal(generator: np.random.Generator, n_out: int, n_in: int) -> np.ndarray:
    """Return a random f64[n_out, n_in] with orthonormal rows or columns, whichever are fewer."""
    columns = normals(generator, (min(n_out, n_in), max(n_out, n_in)))
    _orthonormalise(columns)
    return columns.T if n_out >= n_in else columns


def normals(generator: np.random.Generator, shape: tuple[int, int]) -> np.ndarray:
    """Return normal numbers f64 of this shape (Box and Muller 1958)."""
    u, v = generator.random((2, *shape))
    numbers: np.ndarray = np.sqrt(-2.0 * arrays.log1p(-u)) * arrays.cos(2.0 * np.pi * v)
    return numbers


@njit
def _orthonormalise(vectors):
    """Make the rows f64[k, n] orthonormal, each against those before it, twice (Giraud et al. 2005)."""
    for i in range(len(vectors)):
        for _ in range(2):
            for j in range(i):
                along = 0.0
                for c in range(vectors.shape[1]):
                    along += vectors[i, c] * vectors[j, c]
                for c in range(vectors.shape[1]):
                    vectors[i, c] -= along * vectors[j, c]
        length = 0.0
        for c in range(vectors.shape[1]):
            length += vectors[i, c] * vectors[i, c]
        vectors[i] /= np.sqrt(length)
