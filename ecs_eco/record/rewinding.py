"""Taking back what a recorder that keeps its series in memory has noted, as its world goes back in time."""

from __future__ import annotations

import numpy as np

from ecs_eco.record.parts import stocks
from ecs_eco.record.recorder import PAGES, Recorder

Mark = tuple[int, tuple[np.ndarray, ...], dict[str, np.ndarray]]
"""Where a recording was: its last tick that is over, stocks and sums, and the page of the tick to come."""


def can_go_back(recorder: Recorder) -> bool:
    """Whether a recording can be taken back: nothing of it is in files, and no single events are kept."""
    return recorder.sink is None and not recorder.keeps and recorder.details is None


def mark(recorder: Recorder) -> Mark:
    """Return where a recording is, between two ticks."""
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
