"""Heavy columns (brains, rollouts) stored in fixed-size blocks, so that growing copies nothing."""

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.vectors import LANES, prefetch
from ecs_eco.engine.addresses import address_of, column_at

Rows: TypeAlias = int | np.integer | slice | np.ndarray
BLOCK = 256  # rows per block
SPARE = 16  # padding after a block: vector loads of the last row extend beyond it


class Blocked:
    """A column [capacity, …] stored as a list `blocks` of arrays [BLOCK, …]: row r is `blocks[r // BLOCK][r %
    BLOCK]`.

    You can index rows as in an array. Kernels take `by_address` and call `block_of` for each row.
    """

    __slots__ = ("addresses", "blocks", "capacity", "dtype", "inner")

    def __init__(self, shape: tuple[int, ...], dtype: DTypeLike) -> None:
        self.inner, self.dtype, self.capacity = tuple(shape), np.dtype(dtype), 0
        self.blocks: list[np.ndarray] = []
        self.addresses = np.empty(0, np.uint64)  # one per block

    @property
    def shape(self) -> tuple[int, ...]:
        """Return (capacity, …), the shape as an array."""
        return (self.capacity, *self.inner)

    @property
    def nbytes(self) -> int:
        """Return the size of all blocks in bytes, including rows in the last block beyond the capacity."""
        return sum(b.nbytes for b in self.blocks)

    def __len__(self) -> int:
        return self.capacity

    def grow(self, n: int) -> "Blocked":
        """Grow to `n` rows and return the column; new rows are zero."""
        size = BLOCK * int(np.prod(self.inner))
        while len(self.blocks) * BLOCK < n:
            self.blocks.append(np.zeros(size + SPARE, self.dtype)[:size].reshape(BLOCK, *self.inner))
        self.addresses = np.array([address_of(block) for block in self.blocks], np.uint64)
        self.capacity = max(self.capacity, n)
        return self

    def by_address(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the addresses of the blocks, and one block: the form in which kernels take a column."""
        return self.addresses, self.blocks[0]

    def copy(self) -> np.ndarray:
        """Return all rows as one array."""
        return self[np.arange(self.capacity)]

    def parts(self, rows: np.ndarray) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
        """Yield (block number, rows within the block i64, their positions in `rows` i64) for each block, in
        the given order."""
        if not rows.size:
            return
        inside, places = np.empty((2, rows.size), np.int64)
        start = 0
        for block, end in enumerate(_sort_out(rows, inside, places).tolist()):
            if end > start:
                yield block, inside[start:end], places[start:end]
                start = end

    def __getitem__(self, rows: Rows) -> np.ndarray:
        if isinstance(rows, int | np.integer):
            return self.blocks[self._row(rows) // BLOCK][rows % BLOCK]
        rows = self._rows(rows)
        out = np.empty((rows.size, *self.inner), self.dtype)
        for b, inside, places in self.parts(rows):
            out[places] = self.blocks[b][inside]
        return out

    def __setitem__(self, rows: Rows, value: ArrayLike) -> None:
        if isinstance(rows, int | np.integer):
            self.blocks[self._row(rows) // BLOCK][rows % BLOCK] = value
            return
        rows = self._rows(rows)
        values = np.asarray(value, self.dtype)
        each = values.ndim > len(self.inner)  # one value per row, not one for all rows
        for b, inside, places in self.parts(rows):
            self.blocks[b][inside] = values[places] if each and len(values) > 1 else values

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> np.ndarray:
        return np.asarray(self.copy(), dtype)

    def _row(self, row: int | np.integer) -> int:
        if not 0 <= row < self.capacity:
            raise IndexError(f"row {row} of a column of {self.capacity}")
        return int(row)

    def _rows(self, rows: slice | np.ndarray) -> np.ndarray:
        if isinstance(rows, slice):
            return np.arange(*rows.indices(self.capacity))
        rows = np.asarray(rows)
        rows = np.flatnonzero(rows) if rows.dtype == bool else rows.astype(np.int64)
        if rows.size and not 0 <= rows.min() <= rows.max() < self.capacity:
            raise IndexError(f"rows up to {rows.max()} of a column of {self.capacity}")
        return rows


@njit
def block_of(row, column):
    """Return the block [BLOCK, …] of a `by_address` column that contains a row."""
    addresses, like = column
    return column_at(addresses[row // BLOCK], like, like.shape)


@njit
def flat_block_of(row, column):
    """Return the block of a `by_address` column that contains a row; it is flat, because reshaping takes
    time."""
    addresses, like = column
    return column_at(addresses[row // BLOCK], like, like.size)


@njit
def apart(row, other, column):
    """Return the distance, in array elements, from one row to another in a `by_address` column."""
    addresses, like = column
    blocks = np.int64(addresses[other // BLOCK]) - np.int64(addresses[row // BLOCK])
    return blocks // like.itemsize + (other % BLOCK - row % BLOCK) * (like.size // BLOCK)


@njit
def prefetch_row(row, column):
    """Prefetch a row of a `by_address` column whose numbers take up to 4 bytes each."""
    block = flat_block_of(row, column)
    n = block.size // BLOCK
    start = row % BLOCK * n
    for at in range(start, start + n, LANES):
        prefetch(block, at)


@njit
def _sort_out(rows, inside, places):
    """Write the rows within their blocks and their positions in `rows` i64[n], block by block; return the end
    of each block among them: i64[blocks]."""
    ends = np.zeros(rows.max() // BLOCK + 1, np.int64)
    for row in rows:
        ends[row // BLOCK] += 1
    ends = np.cumsum(ends)
    at = ends.copy()
    for place in range(rows.size - 1, -1, -1):
        block = rows[place] // BLOCK
        at[block] -= 1
        inside[at[block]], places[at[block]] = rows[place] - block * BLOCK, place
    return ends
