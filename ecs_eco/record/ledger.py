"""The energy ledger: its columns, addressed by name, and the sources of its flows."""

from collections.abc import Mapping
from typing import Any

import numpy as np

FLOWS = {"taken_in": "taken", "burnt": "burnt", "given": "given"}
"""The columns that sum flows of the living in a tick → the fields of `Metabolism` with the flow of one organism."""

LEDGER = ("stock_before", "endowed", *FLOWS, "lost", "stock_after")
"""The columns of the ledger, in the order of recordings and checkpoints."""

MIGRATION = ("imported", "exported")
"""Further columns of the ledger of an island: the energy of immigrants and emigrants."""

COUNTS_ROW = np.dtype([(name, np.int32) for name in ("n", "births", "deaths", "refused")])
LEDGER_ROW = np.dtype([(name, np.float64) for name in LEDGER])
ISLAND_COUNTS_ROW = np.dtype([*COUNTS_ROW.descr, ("immigrants", np.int32), ("emigrants", np.int32)])
ISLAND_LEDGER_ROW = np.dtype([*LEDGER_ROW.descr, *((name, np.float64) for name in MIGRATION)])


def imbalance(ledger: Mapping[str, Any] | np.ndarray | np.void) -> Any:
    """Return the imbalance of the ledger [energy], 0 if it closes, from any object with its columns."""
    inflow = ledger["stock_before"] + ledger["endowed"] + ledger["taken_in"]
    names: Any = getattr(getattr(ledger, "dtype", None), "names", None) or ledger
    if "imported" in names:
        inflow = inflow + ledger["imported"] - ledger["exported"]
    return inflow - ledger["burnt"] - ledger["given"] - ledger["lost"] - ledger["stock_after"]
