"""Random orthogonal matrices of the portable mode, with the same order of sums on every machine.

Libraries choose that order by the processor.
"""

from __future__ import annotations

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.compiled.jit import njit


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
    """Orthonormalize the rows f64[k, n], each against those before it, twice (Giraud et al. 2005)."""
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
