"""Rewinding of a recorder that keeps its series in memory, when its world goes back in time."""

from __future__ import annotations

import numpy as np

from ecs_eco.record.parts import stocks
from ecs_eco.record.recorder import PAGES, Recorder

Mark = tuple[int, tuple[np.ndarray, ...], dict[str, np.ndarray]]
"""The position of a recording: its last finished tick, stocks and sums, and the page of the next tick."""


def can_go_back(recorder: Recorder) -> bool:
    """Return whether a recording can be rewound: it has written no files and keeps no single events."""
    return recorder.sink is None and not recorder.keeps and recorder.details is None


def mark(recorder: Recorder) -> Mark:
    """Return the position of a recording between two ticks."""
    pages = {name: getattr(recorder, f"_{name}")[recorder._at].copy() for name in PAGES}
    return recorder._last, tuple(array.copy() for array in stocks(recorder)), pages


def go_back(recorder: Recorder, to: Mark) -> None:
    """Forget all ticks after a mark."""
    last, held, pages = to
    recorder.flush()
    blocks = [
        {name: column[block["tick"] <= last] for name, column in block.items()} for block in recorder._blocks
    ]
    recorder._blocks = [block for block in blocks if block["tick"].size]
    recorder._last, recorder._at = last, 0
    for array, was in zip(stocks(recorder), held, strict=True):
        array[...] = was
    for name, page in pages.items():
        array = getattr(recorder, f"_{name}")
        array[...] = 0
        array[0] = page
