"""The unwritten part of a recording, which is summed over the processes of a divided world, and rewound when
a world goes back in time."""

import numpy as np

from ecs_eco.record.events import EVENTS
from ecs_eco.record.recorder import PAGES, Recorder

Mark = tuple[int, tuple[np.ndarray, ...], dict[str, np.ndarray]]
"""The position of a recording: its last finished tick, stocks and sums, and the page of the next tick."""


def page_end(recorder: Recorder) -> int:
    """Return how many rows of the series are in use, including the current tick's."""
    return min(recorder._at + 1, recorder.block)


def sums(recorder: Recorder) -> tuple[np.ndarray, ...]:
    """Return the additive quantities of each tick, each with shape [block, species, …]."""
    counts = recorder._counts.view(np.int32).reshape(recorder.block, len(recorder.names), -1)
    return counts, recorder._died, recorder._sums, recorder._moods, recorder.intake.values


def stocks(recorder: Recorder) -> tuple[np.ndarray, ...]:
    """Return the additive quantities that carry over from tick to tick, each with shape [species, …]."""
    return recorder._stock, recorder.intake.total, recorder.intake.flows


def renew_means(recorder: Recorder, n: int) -> None:
    """Compute the means of the first n rows from the sums."""
    living = np.maximum(recorder._counts["n"][:n], 1)
    recorder._means["energy_mean"][:n] = recorder._ledger["stock_after"][:n] / living
    recorder._means["happiness_mean"][:n] = recorder._moods[:n] / living


def forget(recorder: Recorder) -> None:
    """Clear everything that a recorder has not yet written, because another process keeps it."""
    for array in (*sums(recorder), *stocks(recorder)):
        array[...] = 0
    recorder._events = {kind: [] for kind in EVENTS}
    recorder.learning.rows = {kind: [] for kind in recorder.learning.rows}


def can_go_back(recorder: Recorder) -> bool:
    """Return whether a recording can be rewound: it has written no files and keeps no individual events."""
    return recorder.sink is None and not recorder.keeps and recorder.details is None


def mark(recorder: Recorder) -> Mark:
    """Return the position of a recording between two ticks."""
    pages = {name: getattr(recorder, f"_{name}")[recorder._at].copy() for name in PAGES}
    return recorder._last, tuple(array.copy() for array in stocks(recorder)), pages


def go_back(recorder: Recorder, to: Mark) -> None:
    """Discard all ticks after a mark."""
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
