"""Taking back what a recorder that keeps its series in memory has noted, as its world goes back in time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecs_eco.record.recorder import PAGES, Recorder


class Mark(NamedTuple):
    """Where a recording was: its last tick that is over, stocks, and the page of the tick to come."""

    last: int
    stock: np.ndarray
    pages: dict[str, np.ndarray]


def can_go_back(recorder: Recorder) -> bool:
    """Whether a recording can be taken back: nothing of it is in files, and no single events are kept."""
    return recorder.sink is None and not recorder.keeps and recorder.details is None


def mark(recorder: Recorder) -> Mark:
    """Return where a recording is, between two ticks."""
    pages = {name: getattr(recorder, f"_{name}")[recorder._at].copy() for name in PAGES}
    return Mark(recorder._last, recorder._stock.copy(), pages)


def go_back(recorder: Recorder, to: Mark) -> None:
    """Forget all ticks after a mark."""
    recorder.flush()
    blocks = [
        {name: column[block["tick"] <= to.last] for name, column in block.items()}
        for block in recorder._blocks
    ]
    recorder._blocks = [block for block in blocks if block["tick"].size]
    recorder._stock[:], recorder._last, recorder._at = to.stock, to.last, 0
    for name, page in to.pages.items():
        array = getattr(recorder, f"_{name}")
        array[...] = 0
        array[0] = page
