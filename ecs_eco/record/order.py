"""Recorder states whose species or tables are in a different order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.record.learning import LearningPages

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld


@dataclass
class InOrderOf:
    """Loads the state of a recorder with these species and tables into a world's recorder."""

    world: SpatialWorld
    species: Sequence[str]
    tables: Sequence[str]

    def load(self, state: Mapping[str, np.ndarray]) -> None:
        """Load the state, reordered for the world's recorder."""
        self.world.recorder.load(self._reordered(state))

    def _reordered(self, state: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        out, recorder = dict(state), self.world.recorder
        same = list(self.species) == recorder.names and list(self.tables) == list(self.world.tables)
        if same or sorted(self.species) != sorted(recorder.names):
            return out
        former, now = _places(recorder.names, self.species), _places(self.species, recorder.names)
        for key, array in state.items():
            if key == "stock" or key.startswith("page/"):
                out[key] = array[former]
            elif key.startswith("series/") and key != "series/species" and array.size:
                # by tick, then species
                out[key] = array.reshape(-1, former.size)[:, former].ravel()
            elif key in ("births/species", "deaths/species") or (
                key.startswith("learning/") and key.endswith("/species")
            ):
                out[key] = now[array].astype(array.dtype)
        if (key := "learning/actions/action") in state:
            known = LearningPages(self.world, self.species).actions
            out[key] = _places(known, recorder.learning.actions)[state[key]].astype(state[key].dtype)
        if recorder.matter is not None:
            out |= self._matter(state)
        return out

    def _matter(self, state: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return the pages of matter, whose holders are tables in order, then fields."""
        holders: list[Any] = list(self.world.matter.holders)
        known = sorted(
            holders,
            key=lambda holder: self.tables.index(holder[1]) if holder[0] == "table" else len(self.tables),
        )
        former, now = _places(holders, known), _places(known, holders)
        out = {key: state[key][former] for key in ("matter/stock", "matter/flows") if key in state}
        if (key := "matter/series/holder") in state:
            out[key] = now[state[key]].astype(state[key].dtype)
        return out


def _places(names: Sequence[Any], among: Sequence[Any]) -> np.ndarray:
    """Return the index of each name in other names: i64[names]."""
    return np.array([list(among).index(name) for name in names], np.int64)
