"""Details: the senses, weights, decisions and happiness of individual organisms in every tick of a run,
for `--record focal=N` or `full`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Metabolism, Nervous, Position
from ecs_eco.engine.errors import refusal
from ecs_eco.nervous.thoughts import numbers_of, thinkers, weighed

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.nervous.nerves import Nerves
    from ecs_eco.space.world import SpatialWorld

KIND = "details-"  # followed by the species' name: a folder in the run's folder
ROWS = 100_000  # maximum number of rows per species in memory
PLACE = ("x", "y", "z", "heading")
FIXED = 14  # columns that all species have
NOBODY = np.zeros(0, np.int64)


def how_many(record: str | None, source: str = "--record") -> int | None:
    """Return how many organisms of a species `record` requests; None: all. Raises ConfigError."""
    if not record:
        return 0
    if record == "full":
        return None
    word, _, number = record.partition("=")
    if word == "focal" and number.isdecimal() and 1 <= int(number) <= 1_000_000:
        return int(number)
    near = "full" if record.startswith("fu") else "focal=50"
    raise refusal((), "invalid value", record, "focal=N with N from 1 to 1000000, or full", near, source)


def columns_of(nerves: Nerves) -> list[str]:
    """Return the column names of a species' details, in order.

    For a continuous action, reflex is the reflex's contribution, chosen is the policy's draw and decision is
    the executed value: f32, in the action's unit.
    """
    actions = [f"{group}.{name}" for group, name in nerves.actions]
    free = [action for action, has in zip(actions, has_probability(nerves), strict=True) if has]
    return [
        "tick",
        "uid",
        *PLACE,
        "energy",
        "happiness",
        "reward",
        *(f"sensor: {name}" for name in nerves.channels),
        *(f"reflex: {a}" for a in actions),
        *(f"probability: {a}" for a in free),
        *(f"chosen: {a}" for a in actions),
        *(f"decision: {a}" for a in actions),
    ]


def has_probability(nerves: Nerves) -> np.ndarray:
    """Return which actions the policy can choose: bool[actions]."""
    out = np.zeros(len(nerves.actions), np.bool_)
    if nerves.policy:
        out[nerves.targets[nerves.targets >= 0]] = True
    return out


class Details:
    """Collects details for every species that has a nervous system, from all members or from a focal sample.

    A species' sample starts with the `most` organisms that have the lowest uids. Dead organisms are replaced
    by newborns in order of uid, so organisms that join later are followed from birth to death. A dying
    organism's last tick is recorded, too. Rows are passed to `sink("details-SPECIES", columns)`.
    """

    def __init__(self, world: SpatialWorld, most: int | None, sink: Any) -> None:
        self.most, self.sink = most, sink
        self.species = [
            name for name in world.species_names() if world.tables[name].species.nerves is not None
        ]
        self.focal = {
            name: world.tables[name].uid[world.tables[name].by_uid()[: self.most]] for name in self.species
        }
        # uids of organisms born since the last recorded tick
        self._born: dict[str, list[np.ndarray]] = {name: [] for name in self.species}
        # details of organisms that die in the current tick
        self._dying: dict[str, list[tuple[np.ndarray, ...]]] = {name: [] for name in self.species}
        self._blocks: dict[str, list[tuple[np.ndarray, ...]]] = {name: [] for name in self.species}
        self._rows = dict.fromkeys(self.species, 0)

    def born(self, table: Table, rows: np.ndarray) -> None:
        """Register newborns in rows i64[k]."""
        if table.name in self.focal and self.most is not None:
            self._born[table.name].append(table.uid[rows])

    def died(self, table: Table, rows: np.ndarray, world: SpatialWorld) -> None:
        """Record the last tick of dying organisms before their rows are freed."""
        if table.name not in self.focal:
            return
        uids = table.uid[rows]
        if self.most is not None:
            focal = self.focal[table.name]
            uids = uids[np.isin(uids, focal)]
            self.focal[table.name] = np.setdiff1d(focal, uids) if uids.size else focal
        if world.ticking and uids.size:
            self._dying[table.name].append(self._of(table, world, uids))

    def note(self, world: SpatialWorld) -> None:
        """Record a finished tick."""
        for name in self.species:
            blocks = [
                *self._dying[name],
                self._of(world.tables[name], world, None if self.most is None else self.focal[name]),
            ]
            self._dying[name] = []
            self._admit(name)
            self._blocks[name] += blocks
            self._rows[name] += sum(len(block[0]) for block in blocks)
            if self._rows[name] >= ROWS:
                self._hand_over(name, world)

    def flush(self, world: SpatialWorld) -> None:
        """Pass all recorded rows to the sink."""
        for name in self.species:
            self._hand_over(name, world)

    def state(self) -> dict[str, np.ndarray]:
        """Return the state after `flush`: the sample, and the organisms born since the last recorded tick."""
        out = {f"focal/{name}": uids for name, uids in self.focal.items()} if self.most is not None else {}
        return out | {f"waiting/{name}": np.concatenate(born) for name, born in self._born.items() if born}

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Continue from a `state()`."""
        for name in self.species:
            self.focal[name] = state.get(f"focal/{name}", self.focal[name])
            self._born[name] = [state[f"waiting/{name}"]] if f"waiting/{name}" in state else []
            self._dying[name], self._blocks[name], self._rows[name] = [], [], 0

    def _admit(self, name: str) -> None:
        """Replace dead organisms in the sample with newborns."""
        born, self._born[name] = self._born[name], []
        if self.most is not None and born and (room := self.most - len(self.focal[name])) > 0:
            self.focal[name] = np.union1d(self.focal[name], np.sort(np.concatenate(born))[:room])

    def _of(self, table: Table, world: SpatialWorld, uids: np.ndarray | None) -> tuple[np.ndarray, ...]:
        """Return the details of this tick: a row for each of these uids (None: all), in order."""
        nerves, felt, p = table.species.nerves, table[Nervous], table[Position]
        thoughts = nerves.thoughts
        if thoughts is None or thoughts.tick != world.tick:
            return (NOBODY,)
        rows, at = thinkers(table, uids)
        if not rows.size:
            return (NOBODY,)
        energy = table[Metabolism].energy[rows] if Metabolism in table else np.zeros(rows.size, np.float32)
        n = len(nerves.actions)
        y = np.zeros((rows.size, n), np.int8) if thoughts.y is None else thoughts.y[at].astype(np.int8)
        logits = np.zeros((rows.size, 0), np.float32) if thoughts.logits is None else thoughts.logits[at]
        numbers = numbers_of(table, rows, at) if len(nerves.ranges) else ()
        return (
            np.full(rows.size, world.tick),
            table.uid[rows],
            *(getattr(p, axis)[rows] for axis in PLACE),
            energy,
            felt.happiness[rows],
            felt.reward[rows],
            nerves.x[at],
            y,
            logits,
            thoughts.choice[at],
            felt.decision[rows],
            *numbers,
        )

    def _hand_over(self, name: str, world: SpatialWorld) -> None:
        """Pass a species' recorded rows to the sink, sorted by tick, then uid."""
        blocks, self._blocks[name], self._rows[name] = [b for b in self._blocks[name] if b[0].size], [], 0
        if not blocks:
            return
        nerves = world.tables[name].species.nerves
        parts = [np.concatenate(part) for part in zip(*blocks, strict=True)]
        order = np.lexsort((parts[1], parts[0]))
        *single, x, y, logits, choice, decision = (part[order] for part in parts[:FIXED])
        p, z = weighed(nerves, logits if logits.shape[1] else None, choice)
        shift, chosen, command = [part[order].T for part in parts[FIXED:]] if len(nerves.ranges) else [()] * 3
        numbers: tuple[Any, ...] = (), shift, (), chosen, command
        for matrix, own in zip((x, y, p[:, has_probability(nerves)], z, decision), numbers, strict=True):
            columns = list(matrix.T)
            for column, values in zip(nerves.ranges.columns, own, strict=False):
                columns[column] = values
            single += columns
        self.sink(KIND + name, dict(zip(columns_of(nerves), single, strict=True)))
