"""The energy ledger: its columns, addressed by name, and the sources of its flows."""

from collections.abc import Mapping
from typing import Any

import numpy as np

FLOWS = {"taken_in": "taken", "burnt": "burnt", "given": "given"}
"""Columns that sum a flow over living organisms → field of `Metabolism` with one organism's flow."""

LEDGER = ("stock_before", "endowed", *FLOWS, "lost", "stock_after")
"""The columns of the ledger, in the order used in recordings and checkpoints."""

MIGRATION = ("imported", "exported")
"""Additional ledger columns of an island: the energy of immigrants and emigrants."""

COUNTS_ROW = np.dtype([(name, np.int32) for name in ("n", "births", "deaths", "refused")])
LEDGER_ROW = np.dtype([(name, np.float64) for name in LEDGER])
ISLAND_COUNTS_ROW = np.dtype([*COUNTS_ROW.descr, ("immigrants", np.int32), ("emigrants", np.int32)])
ISLAND_LEDGER_ROW = np.dtype([*LEDGER_ROW.descr, *((name, np.float64) for name in MIGRATION)])


def imbalance(ledger: Mapping[str, Any] | np.ndarray | np.void) -> Any:
    """Return the imbalance [energy] of a ledger (any object with its columns); 0 if it closes."""
    inflow = ledger["stock_before"] + ledger["endowed"] + ledger["taken_in"]
    names: Any = getattr(getattr(ledger, "dtype", None), "names", None) or ledger
    if "imported" in names:
        inflow = inflow + ledger["imported"] - ledger["exported"]
    return inflow - ledger["burnt"] - ledger["given"] - ledger["lost"] - ledger["stock_after"]
