"""Recent deaths of animals with their places, which the page marks in the scene."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ecs_eco.view.parts import Blocks

TICKS = 5  # for which a mark is shown
MOST = 100  # marks in a message, the latest ones
Fate = tuple[int, int, int, float, float, float, int]
"""Tick, species (its number), uid, x, y, z [m], uid of the killer or 0."""


def latest(deaths: Blocks, animals: Collection[int], after: int, tick: int) -> list[Fate]:
    """Return the deaths of these species, given by number, after tick `after` and up to `tick`, at most of
    the last five ticks. Plants are left out because they die too often to be marked."""
    names = ("tick", "species", "uid", "x", "y", "z", "killer")
    columns = deaths.between(max(after + 1, tick - TICKS + 1), tick, names)
    rows = np.flatnonzero(np.isin(columns["species"], list(animals)))[-MOST:]
    x, y, z = (columns[axis].astype(np.float64).round(2) for axis in "xyz")
    return [
        (
            int(columns["tick"][r]),
            int(columns["species"][r]),
            int(columns["uid"][r]),
            float(x[r]),
            float(y[r]),
            float(z[r]),
            int(columns["killer"][r]),
        )
        for r in rows.tolist()
    ]
