"""Births and deaths a tick of a recorded run, and its story."""

from __future__ import annotations

from functools import cached_property, partial
from typing import Any

import numpy as np

from ecs_eco.config.models.reporters import EATEN
from ecs_eco.view import flows
from ecs_eco.view.recording import Recording
from ecs_eco.view.story import Story, foods_of

LONGEST = 60_000_000  # values of the series beyond which neither is told
STEPS = 100_000  # ticks that a story looks at
DIED = "died: "
FLOWS = {"taken_in": "taken in", "burnt": "burnt"}  # columns of the ledger


class Told:
    """What the series of a recording say of births and deaths; read when it is first asked for."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording

    @cached_property
    def causes(self) -> list[str]:
        """The causes of death that occur."""
        names = dict.fromkeys(n for group in self._recording.series.groups for n in group.names)
        return [name.removeprefix(DIED) for name in names if name.startswith(DIED)]

    @cached_property
    def _sums(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Numbers and births i64[ticks, s] and deaths i64[ticks, s, causes], births and deaths since the
        first tick; None where they are too many."""
        r, causes = self._recording, self.causes
        ticks, s = r.last + 1 - r.first, len(r.species)
        if ticks * s * (len(causes) + 2) > LONGEST:
            return None
        n, births = np.zeros((ticks, s), np.int64), np.zeros((ticks, s), np.int64)
        deaths = np.zeros((ticks, s, len(causes)), np.int64)
        for c in r.series.each(("tick", "species", "n", "births", *(DIED + cause for cause in causes))):
            at = c["tick"] - r.first, c["species"]
            n[at], births[at] = c["n"], c["births"]
            for k, cause in enumerate(causes):
                deaths[(*at, k)] = c[DIED + cause]
        return n, births.cumsum(axis=0), deaths.cumsum(axis=0)

    @cached_property
    def entries(self) -> list[dict[str, Any]]:
        """The story of the whole run; [] of one that is too long."""
        r = self._recording
        if self._sums is None:
            return []
        n, births, deaths = self._sums
        story = Story(r.species, foods_of(r.manifest.get("config")), self.causes.__getitem__)
        step = max(1, len(n) // STEPS)
        for i in range(0, len(n), step):
            story.note(r.first + i, n[i], births[i], partial(deaths.__getitem__, i), births[i] > births[0])
        return story.entries

    def rates(self, ticks: np.ndarray) -> dict[str, Any]:
        """Return births, deaths and deaths by cause a tick, between these ticks, by species; {} of a run
        that is too long."""
        if self._sums is None or ticks.size < 2:
            return {}
        _, births, deaths = self._sums
        at, span = ticks - self._recording.first, np.diff(ticks)
        out: dict[str, Any] = {"births": {}, "deaths": {}, "causes": {}}
        for s, name in enumerate(self._recording.species):
            rate = np.diff(deaths[at, s], axis=0) / span[:, None]
            out["births"][name] = _listed(np.diff(births[at, s]) / span)
            out["deaths"][name] = _listed(rate.sum(axis=1))
            out["causes"][name] = {
                cause: _listed(rate[:, k]) for k, cause in enumerate(self.causes) if deaths[-1, s, k]
            }
        return out

    def energy(self, ticks: np.ndarray) -> dict[str, Any]:
        """Return what each species took in and burnt at these ticks [energy], by species; {} of a long run."""
        r = self._recording
        if self._sums is None:
            return {}
        flows = {words: self._column(name) for name, words in FLOWS.items()}
        return {
            name: {words: [float(f"{v:.5g}") for v in of[ticks - r.first, s]] for words, of in flows.items()}
            for s, name in enumerate(r.species)
            if any(of[:, s].any() for of in flows.values())
        }

    def _column(self, name: str) -> np.ndarray:
        """Return a column of the series, 0 where nothing was recorded: f64[ticks, species]."""
        out = np.zeros((self._recording.last + 1 - self._recording.first, len(self._recording.species)))
        for c in self._recording.series.each(("tick", "species", name)):
            out[c["tick"] - self._recording.first, c["species"]] = c[name]
        return out

    def depths(self, ticks: np.ndarray) -> dict[str, list[float | None]]:
        """Return mean depths at these ticks, as heights below 0 [m], of those that move; {} of no water."""
        r = self._recording
        if self._sums is None or not any("depth_mean" in group.names for group in r.series.groups):
            return {}
        deep = np.where(self._sums[0] > 0, -self._column("depth_mean"), np.nan)
        moves = {name for name, s in r.manifest["config"]["species"].items() if s.get("locomotion")}
        return {
            name: [None if np.isnan(v) else float(f"{v:.5g}") for v in deep[ticks - r.first, s]]
            for s, name in enumerate(r.species)
            if name in moves
        }

    def flows(self, ticks: np.ndarray) -> dict[str, Any]:
        """Return what flowed a tick between these ticks, by species; see `ecs_eco.view.flows`."""
        r = self._recording
        if self._sums is None or ticks.size < 2:
            return {}
        names = dict.fromkeys(name for group in r.series.groups for name in group.names)
        at, sums = ticks - r.first, {}
        for column in [name for name in names if name in flows.FLOWS or name.startswith(EATEN)]:
            sums[column] = self._column(column).cumsum(axis=0)[at]
        foods, by = foods_of(r.manifest.get("config")), "eaten by "
        meals = {
            (food, cause.removeprefix(by)): self._sums[2][at, s, k]
            for s, food in enumerate(r.species)
            for k, cause in enumerate(self.causes)
            if cause.startswith(by)
        }
        said = flows.recorded(sums, r.species, ticks, foods, meals)
        return {"flows": said} | ({} if any(name.startswith(EATEN) for name in sums) else {"shared": True})


def _listed(values: np.ndarray) -> list[float | None]:
    return [None, *np.round(values, 4).tolist()]
