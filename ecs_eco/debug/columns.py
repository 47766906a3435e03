"""Errors of the checks, views of a table for them, and names for its rows."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ecs_eco.components import Metabolism
from ecs_eco.engine.table import Table
from ecs_eco.record.ledger import FLOWS

IDENTITY = ("alive", "uid", "born")  # columns that change only in flushes


class DebugError(RuntimeError):
    """Raised by a failed check of the debug mode, with the system, tick, species and organism."""


class StaleHandle(DebugError):
    """Raised for a handle that was used after its owner's death."""


def columns(table: Table) -> Iterator[tuple[Any, str, Any]]:
    """Yield (component, name, array) for every column."""
    for component, held in table.columns.items():
        for name, array in vars(held).items():
            yield component, name, array


def budget(table: Table) -> dict[str, np.ndarray]:
    """Return energy and flows of a table with Metabolism; {} for other tables."""
    return (
        {n: getattr(table[Metabolism], n) for n in ("energy", *FLOWS.values())} if Metabolism in table else {}
    )


def bytes_of(array: np.ndarray) -> np.ndarray:
    """Return the rows of an array as bytes u8[n, …], so that NaN equals itself and −0 differs from 0."""
    array = np.ascontiguousarray(array)
    return array.reshape(len(array), -1).view(np.uint8).reshape(len(array), -1)


def owner_of(uid: np.ndarray, row: int | np.integer) -> str:
    """Return a phrase for a row: its owner's uid, or that it is free."""
    return f"uid {int(uid[row])} (row {int(row)})" if uid[row] else f"row {int(row)}, which is free,"


def more(n: int) -> str:
    """Return a phrase for all but the first of n."""
    return f" ({n - 1} more)" if n > 1 else ""
