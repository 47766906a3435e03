"""Births and deaths of a live world, noted as they happen, in the same form as in a recorded run."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ecs_eco.components import Position
from ecs_eco.ecosystem import World
from ecs_eco.engine.table import Table
from ecs_eco.view.parts import Kept

MOST = 500_000  # births (and deaths) to keep; beyond that, the oldest are dropped
SIZE = 20_000  # maximum number of rows entered together; 4 times as many as in a group, which is copied as it grows
CAUSES = 256
COLUMNS = {"births": ("uid", "parent", "parent2"), "deaths": ("uid", "cause", "killer", "age", "x", "y", "z")}
"""The columns of each kind, after tick and species."""


class Journal:
    """The births and deaths of a world, from the creation of this object onward. Organisms already alive are
    entered as births without parents. `species` are the table names by species number. `born` i64[species]
    counts births; `bred` bool[species] is true once a parent of the species has reproduced; `died`
    i64[species, causes] counts deaths, with causes numbered from 1, and 0 for unknown ones."""

    def __init__(self, world: World, species: Sequence[str] = (), most: int = MOST, size: int = SIZE) -> None:
        self.world, self.size = world, size
        self.species = [*species, *(name for name in world.tables if name not in species)]
        self._organisms = len(species) or len(self.species)  # species before objects
        self.dt, self._place = world.dt, {name: s for s, name in enumerate(self.species)}
        self._kept = {kind: Kept(size // 4, most) for kind in COLUMNS}
        self._waiting: dict[str, list[tuple[Any, ...]]] = {kind: [] for kind in COLUMNS}
        self._heard = 0
        k = len(self.species)
        self.born, self.bred = np.zeros(k, np.int64), np.zeros(k, np.bool_)
        self.died = np.zeros((k, CAUSES), np.int64)
        self._note_the_living()
        world.on_birth.append(self._was_born)
        world.on_death.append(self._has_died)

    @property
    def births(self) -> Kept:
        """Births: tick, species, uid, parent, parent2."""
        self._settle()
        return self._kept["births"]

    @property
    def deaths(self) -> Kept:
        """Deaths: tick, species, uid, cause (−1: unknown), killer, age [s], x, y, z [m]."""
        self._settle()
        return self._kept["deaths"]

    @property
    def causes(self) -> Sequence[str]:
        """The causes of death."""
        return self.world.causes

    def cause(self, number: int) -> str:
        """Return the cause of death with a number as in `died`."""
        return self.world.causes[number - 1] if number else "unknown"

    def mark(self) -> tuple[np.ndarray, ...]:
        """Return all counts so far."""
        return self.born.copy(), self.bred.copy(), self.died.copy()

    def go_back(self, tick: int, next_uid: int, mark: tuple[np.ndarray, ...]) -> None:
        """Drop births and deaths from a tick onward. `next_uid` was the first free uid at that tick."""
        self._settle()
        self._kept["births"].keep("uid", next_uid)
        self._kept["deaths"].keep("tick", tick)
        self.born, self.bred, self.died = (array.copy() for array in mark)

    def _note_the_living(self) -> None:
        living = [
            (table.uid[rows], table.born[rows], np.full(rows.size, self._place[name], np.int16))
            for name, table in self.world.tables.items()
            if (rows := table.rows()).size
        ]
        if living:
            uid, tick, species = (np.concatenate(column) for column in zip(*living, strict=True))
            order, none = np.argsort(uid), np.zeros(uid.size, np.uint64)
            columns = {"tick": tick[order], "species": species[order], "uid": uid[order]}
            self._kept["births"].add(columns | {"parent": none, "parent2": none})

    def _was_born(self, table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        s = self._place[table.name]
        self.born[s] += rows.size
        if s >= self._organisms:  # an object has a builder, but no parents
            parents = second = np.zeros_like(parents)
        if not self.bred[s]:
            self.bred[s] = parents.any()
        self._hear("births", s, table.uid[rows], parents, second)

    def _has_died(self, table: Table, rows: np.ndarray) -> None:
        s, causes = self._place[table.name], table.cause[rows]
        p = table[Position] if Position in table else None
        at = [np.zeros(rows.size, np.float32)] * 3 if p is None else [p.x[rows], p.y[rows], p.z[rows]]
        counts = np.bincount(causes)
        self.died[s, : counts.size] += counts
        self._hear("deaths", s, table.uid[rows], causes, table.killer[rows], table.born[rows], *at)

    def _hear(self, kind: str, s: int, *columns: np.ndarray) -> None:
        self._waiting[kind].append((self.world.tick, s, *columns))
        self._heard += columns[0].size + 50  # 50 for the memory overhead of each call
        if self._heard > self.size:
            self._settle()

    def _settle(self) -> None:
        """Enter all pending births and deaths."""
        self._heard = 0
        for kind, waiting in self._waiting.items():
            if not waiting:
                continue
            ticks, species, *columns = zip(*waiting, strict=True)
            size = [uid.size for uid in columns[0]]
            entered = {name: np.concatenate(c) for name, c in zip(COLUMNS[kind], columns, strict=True)}
            entered |= {
                "tick": np.repeat(ticks, size),
                "species": np.repeat(np.array(species, np.int16), size),
            }
            if kind == "deaths":
                entered["cause"] = entered["cause"].astype(np.int16) - 1
                entered["age"] = (entered["tick"] - entered["age"]) * self.dt  # of the tick of birth
            waiting.clear()
            self._kept[kind].add(entered)
