"""The organisms at any tick of a recorded run, interpolated between snapshots, births and deaths."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecs_eco.engine.uids import matched
from ecs_eco.view.parts import Columns

STATE = ("x", "y", "z", "heading", "energy", "happiness")
EVENT = ("uid", "species", "x", "y", "z", "energy")


class Organisms(NamedTuple):
    """The living organisms of a species at a tick, by uid; `exact` marks states recorded at this tick."""

    uid: np.ndarray  # u64[n]
    x: np.ndarray  # f32[n] [m], like y and z
    y: np.ndarray
    z: np.ndarray
    heading: np.ndarray  # f32[n] [rad]
    energy: np.ndarray
    happiness: np.ndarray  # NaN where unknown
    exact: np.ndarray  # bool[n]


class Chapter:
    """The ticks from `first` up to but excluding `end`; both are snapshots or ends of the recording.

    The set of organisms is exact, because it follows from births and deaths. Positions and states are
    interpolated linearly from the last record (a snapshot or the birth) to the next (a snapshot or the
    death), along the shorter path on a torus.
    """

    def __init__(
        self,
        first: int,
        end: int,
        before: Columns | None,
        after: Columns | None,
        births: Columns,
        deaths: Columns,
        size: Sequence[float],
        torus: bool,
    ) -> None:
        self.first, self.end = first, end
        self.size, self.torus = [*size, 0.0][:3], torus
        unknown = np.full(births["uid"].size, np.nan, np.float32)
        born = {**births, "heading": unknown, "happiness": unknown}
        names, n = ("uid", "species", *STATE), 0 if before is None else before["uid"].size
        earlier = born if before is None else {k: np.concatenate([before[k], born[k]]) for k in names}
        order = np.lexsort((earlier["uid"], earlier["species"]))
        since = np.concatenate([np.full(n, first), np.maximum(births["tick"], first)])
        self.uid, self.since = earlier["uid"][order].astype(np.uint64), since[order]
        self.species = earlier["species"][order]
        self.start = np.stack([earlier[k][order].astype(np.float32) for k in STATE])  # f32[6, n]
        self.goal, self.until = self.start.copy(), np.full(self.uid.size, end)
        self.dies = np.zeros(self.uid.size, np.bool_)
        by_uid = np.argsort(self.uid, kind="stable")
        if after is not None:
            self._lead(by_uid, after, STATE, end)
        ended = self._lead(by_uid, deaths, ("x", "y", "z", "energy"), deaths["tick"])
        self.dies[ended] = True
        missing = np.isnan(self.start)
        self.start[missing] = self.goal[missing]

    def _lead(
        self, by_uid: np.ndarray, columns: Columns, names: Sequence[str], when: int | np.ndarray
    ) -> np.ndarray:
        """Interpolate these organisms to their states at `when`; return their indices."""
        place, there = matched(self.uid[by_uid], columns["uid"].astype(np.uint64))
        at = by_uid[place[there]]
        for name in names:
            self.goal[STATE.index(name), at] = columns[name][there]
        self.until[at] = when if isinstance(when, int) else when[there]
        return at

    def alive(self, tick: int, species: int) -> np.ndarray:
        """Return the indices of a species' organisms that are alive at the end of a tick: i64[k]."""
        a, b = np.searchsorted(self.species, (species, species + 1))
        return a + np.flatnonzero((self.since[a:b] <= tick) & (~self.dies[a:b] | (tick < self.until[a:b])))

    def organisms(self, tick: int, species: int) -> Organisms:
        """Return the living organisms of a species at the end of a tick."""
        at = self.alive(tick, species)
        since = self.since[at]
        share = np.clip((tick - since) / np.maximum(self.until[at] - since, 1), 0, 1).astype(np.float32)
        start, step = self.start[:, at], self.goal[:, at] - self.start[:, at]
        for axis in (0, 1) if self.torus else ():
            step[axis] -= self.size[axis] * np.round(step[axis] / self.size[axis])
        step[3] -= 2 * np.pi * np.round(step[3] / (2 * np.pi))
        now = start + share * step
        for axis in (0, 1) if self.torus else ():
            now[axis] %= self.size[axis]
        now[3] = np.nan_to_num(now[3])
        x, y, z, heading, energy, happiness = now
        return Organisms(self.uid[at], x, y, z, heading, energy, happiness, since == tick)
