"""Single events of a recording: their columns, and text as numbers in checkpoints."""

from __future__ import annotations

import numpy as np

MIGRATION = {
    "arrivals": (
        "tick",
        "species",
        "uid",
        "x",
        "y",
        "z",
        "energy",
        "origin",
        "born",
        "parent",
        "parent2",
        "genome",
    ),
    "departures": ("tick", "species", "uid", "x", "y", "z", "energy", "target"),
}
"""Events of islands: immigrants with origin, birth and parents; emigrants with target."""

EVENTS = {
    "births": ("tick", "species", "uid", "x", "y", "z", "energy", "parent", "parent2", "genome"),
    "deaths": ("tick", "species", "uid", "x", "y", "z", "energy", "cause", "killer", "age"),
    "snapshots": ("tick", "species", "uid", "x", "y", "z", "energy", "heading", "happiness"),
} | MIGRATION


def as_numbers(column: np.ndarray) -> np.ndarray:
    """Return text as the character codes u32[n, letters], other columns unchanged."""
    if column.dtype.kind not in "SU":
        return column
    wide = np.ascontiguousarray(column.astype(f"U{max(1, int(np.char.str_len(column).max(initial=1)))}"))
    return wide.view(np.uint32).reshape(len(column), -1)


def as_text(numbers: np.ndarray) -> np.ndarray:
    """Return the text of character codes."""
    text = np.ascontiguousarray(numbers).view(f"U{numbers.shape[1]}")[:, 0]
    return text.astype("S") if numbers.size and numbers.max() < 128 else text
