"""The curves and story of a recorded run, from its series."""

from functools import cached_property
from typing import Any

import numpy as np

from ecs_eco.config.models.reporters import DIED, EATEN
from ecs_eco.view import curves, flows
from ecs_eco.view.genealogy import LARGEST
from ecs_eco.view.recording import Recording
from ecs_eco.view.story import EVERY, Story, Turn, foods_of, half_of_peak

LONGEST = 60_000_000  # with more values in the series, births, deaths and the story are omitted
STEPS = 100_000  # ticks examined by a story, besides those in which a species appears or disappears


class Past:
    """The history of a recorded run, from its series. Each part is read when first used. `causes` lists the
    causes of death that occurred; `shared` is true if energy was not recorded per food."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._columns = dict.fromkeys(n for group in recording.series.groups for n in group.names)
        self.causes = [name.removeprefix(DIED) for name in self._columns if name.startswith(DIED)]
        self.shared = not any(name.startswith(EATEN) for name in self._columns)
        self.foods, self.eats = (foods_of(recording.manifest.get("config"), h) for h in (False, True))

    @cached_property
    def _counts(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Numbers and total births i64[ticks, s], total deaths i64[ticks, s, causes]; None if too many."""
        r, causes = self._recording, self.causes
        ticks, s = r.last + 1 - r.first, len(r.species)
        if ticks * s * (len(causes) + 2) > LONGEST:
            return None
        columns = ("n", "births", *(DIED + cause for cause in causes))
        n, births, *deaths = (r.column(name).astype(np.int64) for name in columns)
        died = np.stack(deaths, axis=2) if causes else np.zeros((ticks, s, 0), np.int64)
        return n, births.cumsum(axis=0), died.cumsum(axis=0)

    @cached_property
    def entries(self) -> list[dict[str, Any]]:
        """The story of the whole run, or an empty list if the run is too long."""
        r = self._recording
        if self._counts is None:
            return []
        n, births, deaths = self._counts

        def half(s: int, now: Turn) -> Turn | None:
            i = half_of_peak(n[: now.tick - r.first + 1, s])
            return (
                None if i is None else Turn(r.first + i, int(n[i, s]), int(births[i, s]), deaths[i, s], n[i])
            )

        story = Story(r.species, self.foods, self.causes.__getitem__, half)
        start = n[0] - births[0] + deaths[0].sum(axis=1)
        story.note(r.first, start, 0 * births[0], 0 * deaths[0], births[0] < 0)
        steps = EVERY * max(1, -(-len(n) // (EVERY * STEPS)))
        gone = np.diff(n == 0, axis=0, prepend=(start == 0)[None]).any(axis=1)
        for i in np.flatnonzero(gone | ((r.first + np.arange(len(n))) % steps == 0)).tolist():
            story.note(r.first + i, n[i], births[i], deaths[i], self._first_young <= r.first + i)
        return story.entries

    @cached_property
    def _first_young(self) -> np.ndarray:
        """The tick of each species' first birth to parents, or infinity if there is none: f64[s]. If there
        are too many births, the tick of the first birth after the first tick."""
        r = self._recording
        first = np.full(len(r.species), np.inf)
        few = r.births.rows <= LARGEST
        rows, column = (r.births, "parent") if few else (r.series, "births")
        for c in rows.each(("tick", "species", column)):
            of = c["parent"] > 0 if few else (c["births"] > 0) & (c["tick"] > r.first)
            np.minimum.at(first, c["species"][of], c["tick"][of])
        return first

    def levels(self, ticks: np.ndarray) -> dict[curves.Key, np.ndarray]:
        """Return levels at the ticks of the recording's curves, without depths if the run is too long."""
        r, config = self._recording, self._recording.manifest["config"]["species"]
        columns = {
            "n": np.column_stack([*r.curves["n"].values()]),
            "happiness_mean": np.column_stack([*r.curves["happiness"].values()]),
        }
        if self._counts is not None and "depth_mean" in self._columns:
            columns["depth_mean"] = r.column("depth_mean")[ticks - r.first]
        happy, movers = (
            [name for name in r.species if config[name].get(section)]
            for section in ("happiness", "locomotion")
        )
        out = curves.levels_of(columns, r.species, happy, movers)
        for reporter, said in r.curves["reports"].items():
            out |= {("reports", reporter, of): values for of, values in said.items()}
        return out

    def sums(self, ticks: np.ndarray) -> dict[curves.Key, np.ndarray]:
        """Return births, deaths by cause and energy flows up to these ticks, or {} if the run is too long."""
        r = self._recording
        if self._counts is None:
            return {}
        _, births, deaths = self._counts
        at = ticks - r.first
        totals = {"births": births[at]} | {DIED + c: deaths[at, :, k] for k, c in enumerate(self.causes)}
        names = [name for name in self._columns if name in flows.FLOWS or name.startswith(EATEN)]
        totals |= {name: r.column(name).cumsum(axis=0)[at] for name in names}
        return curves.sums_of(totals, r.species, self.foods)
