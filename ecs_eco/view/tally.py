"""The points of curves and the story of a watched living world."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.components import Genome, Metabolism, Nervous, Position, Velocity
from ecs_eco.ecosystem import World
from ecs_eco.engine.table import Table
from ecs_eco.view import flows
from ecs_eco.view.curves import DEPTH, Key, Point, died
from ecs_eco.view.journal import Journal
from ecs_eco.view.scene import sky
from ecs_eco.view.story import EVERY, Story, foods_of


class Tally:
    """The curves and the story of a world, from its tables, its recorder and the journal of births and
    deaths.

    `genes` are the genes of each species that have curves.
    """

    def __init__(self, world: World, journal: Journal, genes: dict[str, list[str]]) -> None:
        self.world, self.journal, self.genes = world, journal, genes
        self.species = list(genes)
        config = None if world.config is None else world.config.model_dump(include={"species"})
        self.foods = foods_of(config)
        self.story = Story(self.species, self.foods, lambda c: world.causes[c - 1] if c else "unknown")
        self._gone: list[bool] = []  # species without organisms at the last check

    def passed(self) -> None:
        """Update the story after a tick."""
        n, over = [self.world.tables[name].n for name in self.species], self.world.tick - 1
        gone = [count == 0 for count in n]
        if gone != self._gone or over % EVERY == 0:
            self._gone, k = gone, len(n)
            births, bred = self.journal.born[:k], self.journal.bred[:k]
            # as in the records: the last completed tick
            self.story.note(max(0, over), np.array(n, np.int64), births, lambda: self.journal.died[:k], bred)

    def point(self) -> Point:
        """Return a point of all curves now."""
        return Point(self.world.tick, self._levels(), self._sums())

    def _levels(self) -> dict[Key, float]:
        """Return numbers, mean happiness (undefined before the first tick), mean values of genes, depths,
        light, and the latest reports. Without a recorder, also return the energy that the living took in and
        burned in the last tick."""
        out: dict[Key, float] = {("light", ""): sky(self.world)[0]}
        for name in self.species:
            table = self.world.tables[name]
            out["n", name] = int(table.n)
            if table.n:
                out |= self._of(name, table, table.rows())
        for name, report in self._reports().items():
            for species, value in (report if isinstance(report, dict) else {"": report}).items():
                out["reports", name, species] = value
        return out

    def _of(self, name: str, table: Table, rows: np.ndarray) -> dict[Key, float]:
        def mean(values: np.ndarray) -> float:
            return float(values.mean(dtype=np.float64))

        out: dict[Key, float] = {}
        if self.world.tick and Nervous in table and table.species.nerves.happiness is not None:
            out["happiness", name] = mean(table[Nervous].happiness[rows])
        if self.genes[name]:
            decoded = table.species.heredity.layout.decode(table[Genome].loci[rows], self.genes[name])
            out |= {("genes", f"{name}.{gene}"): mean(values) for gene, values in decoded.items()}
        if self.world.tick and Metabolism in table and self.world.recorder is None:
            m = table[Metabolism]
            out["energy", name, "taken in"] = float(m.taken[rows].sum(dtype=np.float64))
            out["energy", name, "burnt"] = float(m.burnt[rows].sum(dtype=np.float64))
        if self.world.tick and self.world.space.volume and Velocity in table:  # as heights below 0 [m]
            out["reports", DEPTH, name] = mean(table[Position].z[rows]) - float(self.world.space.size[2])
        return out

    def _reports(self) -> dict[str, float | dict[str, float]]:
        """Return the latest reports of the recorder, or without a recorder the present ones."""
        recorder = self.world.recorder
        if recorder is not None:
            return {} if recorder.reports is None else recorder.reports.latest
        return {name: self.world.measure(name) for name in self.world.reporters}

    def _sums(self) -> dict[Key, float]:
        """Return births, deaths by cause, and energy flows up to now."""
        out, words = flows.of_world(self.world.recorder), ["unknown", *self.world.causes]
        for s, name in enumerate(self.species):
            of = self.journal.died[s]
            causes = [(words[c], float(of[c])) for c in np.flatnonzero(of).tolist()]
            out |= died(name, causes, float(self.journal.born[s]))
        return out

    def mark(self) -> dict[str, Any]:
        """Return the state of the story so far."""
        return {"gone": self._gone, "story": self.story.mark()}

    def go_back(self, mark: dict[str, Any]) -> None:
        """Return to a mark."""
        self._gone = mark["gone"]
        self.story.go_back(mark["story"])
