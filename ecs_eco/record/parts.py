"""The record of one part of a divided world, and how the parts' records are summed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.record.events import EVENTS

if TYPE_CHECKING:
    from ecs_eco.record.recorder import Recorder


def page_end(recorder: Recorder) -> int:
    """Return how many rows of the series are in use, including the row of the current tick."""
    return min(recorder._at + 1, recorder.block)


def sums(recorder: Recorder) -> tuple[np.ndarray, ...]:
    """Return the additive quantities: counts, causes of death, sums of energy and happiness, and energy
    gained from each food, [block, species, …] each."""
    counts = recorder._counts.view(np.int32).reshape(recorder.block, len(recorder.names), -1)
    return counts, recorder._died, recorder._sums, recorder._moods, recorder.intake.values


def stocks(recorder: Recorder) -> tuple[np.ndarray, ...]:
    """Return the additive quantities that continue from tick to tick: [species, …] each."""
    return recorder._stock, recorder.intake.total, recorder.intake.flows


def renew_means(recorder: Recorder, n: int) -> None:
    """Compute the means of the first n rows from the sums."""
    living = np.maximum(recorder._counts["n"][:n], 1)
    recorder._means["energy_mean"][:n] = recorder._ledger["stock_after"][:n] / living
    recorder._means["happiness_mean"][:n] = recorder._moods[:n] / living


def forget(recorder: Recorder) -> None:
    """Clear everything that a recorder has not passed on, because another process has it."""
    for array in (*sums(recorder), *stocks(recorder)):
        array[...] = 0
    recorder._events = {kind: [] for kind in EVENTS}
    recorder.learning.rows = {kind: [] for kind in recorder.learning.rows}
