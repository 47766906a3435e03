"""Errors raised by the checks, and helpers that read a table or describe its rows."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ecs_eco.components import Metabolism
from ecs_eco.engine.table import Table
from ecs_eco.record.ledger import FLOWS

IDENTITY = ("alive", "uid", "born")  # columns that change only in flushes


class DebugError(RuntimeError):
    """Raised when a debug check fails; the message names the system, tick, species and organism."""


class StaleHandle(DebugError):
    """Raised when a handle is used after its organism has died or moved to another row."""


def columns(table: Table) -> Iterator[tuple[Any, str, Any]]:
    """Yield (component, name, array) for every column."""
    for component, held in table.columns.items():
        for name, array in vars(held).items():
            yield component, name, array


def budget(table: Table) -> dict[str, np.ndarray]:
    """Return the energy and flow columns of a table with Metabolism, or {} for other tables."""
    return (
        {n: getattr(table[Metabolism], n) for n in ("energy", *FLOWS.values())} if Metabolism in table else {}
    )


def bytes_of(array: np.ndarray) -> np.ndarray:
    """Return the rows of an array as bytes u8[n, …], so that NaN equals itself and −0 differs from 0."""
    array = np.ascontiguousarray(array)
    return array.reshape(len(array), -1).view(np.uint8).reshape(len(array), -1)


def owner_of(uid: np.ndarray, row: int | np.integer) -> str:
    """Return a phrase that describes a row, by its owner's uid or as free."""
    return f"uid {int(uid[row])} (row {int(row)})" if uid[row] else f"row {int(row)}, which is free,"


def more(n: int) -> str:
    """Return a phrase that counts all but the first of n cases."""
    return f" ({n - 1} more)" if n > 1 else ""
