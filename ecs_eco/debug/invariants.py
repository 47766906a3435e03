"""Conditions that must always be true: consistent rows, finite values, positions in bounds, index order."""

from __future__ import annotations

from typing import Any, NoReturn

import esper
import numpy as np

from ecs_eco.components import Metabolism, Position
from ecs_eco.debug.columns import DebugError, columns, more, owner_of
from ecs_eco.engine.blocks import Blocked
from ecs_eco.engine.system import System
from ecs_eco.engine.table import Table
from ecs_eco.engine.uids import is_given
from ecs_eco.space.world import SpatialWorld

FULL_TURN = 6.2831855  # [rad]


class Invariants:
    """Checks of a world after the step `name`; `system` is set if that step is a system."""

    def __init__(self, world: SpatialWorld, name: str, system: esper.Processor | None = None) -> None:
        self.world, self.name, self.system = world, name, system

    def fail(self, table: Table | None, fault: str, kind: type[DebugError] = DebugError) -> NoReturn:
        """Raise an error that names the system, the tick and the species."""
        where = (
            "" if table is None else f", {'objects' if table.species.is_object else 'species'} {table.name!r}"
        )
        raise kind(f"after {self.name}, tick {self.world.tick}{where}: {fault}")

    def check(self) -> None:
        """Raise a DebugError if a condition is violated."""
        self.check_organisms()
        for table in self.world.tables.values():
            self._nerves(table)
            self._index(table)
            self._resolution(table)
        for name, field in self.world.fields.items():
            if (bad := np.argwhere(~np.isfinite(field.value))).size:
                self.fail(
                    None,
                    f"field {name!r} is {field.value[tuple(bad[0])]} in the cell (z, y, "
                    f"x) = {tuple(bad[0].tolist())}{more(len(bad))}; expected finite numbers",
                )
        if not isinstance(self.system, System):
            self._registry()

    def check_organisms(self) -> None:
        """Raise a DebugError if uids or rows are inconsistent, or values are not finite or out of bounds."""
        for table in self.world.tables.values():
            self._living(table)
            self._finite(table)
            self._bounds(table)
        self._uids()

    def _living(self, table: Table) -> None:
        if table.n != np.count_nonzero(table.alive) or table.alive[table.high :].any():
            self.fail(
                table,
                f"n is {table.n} and high {table.high}, but {np.count_nonzero(table.alive)} rows are alive",
            )
        for name, wrong, fault in (
            ("uid", table.alive & (table.uid == 0), "is alive but has no uid"),
            ("uid", ~table.alive & (table.uid != 0), "is free but has a uid"),
            (
                "cause",
                ~table.alive & (table.cause != 0),
                "is free; deaths are requested only for living organisms",
            ),
        ):
            if (rows := np.flatnonzero(wrong)).size:
                self.fail(
                    table,
                    f"{name} of row {rows[0]} is {getattr(table, name)[rows[0]]}; "
                    f"the row {fault}{more(rows.size)}",
                )

    def _uids(self) -> None:
        seen: dict[int, str] = {}
        tables = list(self.world.tables.values())
        uid = np.concatenate([t.uid[t.alive] for t in tables]) if tables else np.zeros(0, np.uint64)
        uid.sort()
        if not uid.size or (is_given(uid, self.world.next_uid).all() and (uid[1:] != uid[:-1]).all()):
            return
        for table in tables:
            for row in table.rows():
                u = int(table.uid[row])
                if u in seen:
                    self.fail(
                        table, f"uid {u} is in row {row} and in {seen[u]}; each uid may be assigned only once"
                    )
                if not is_given(u, self.world.next_uid):
                    self.fail(
                        table, f"uid {u} is in row {row}, but the next free uid is {self.world.next_uid}"
                    )
                seen[u] = f"row {row} of {table.name!r}"

    def _registry(self) -> None:
        """Check that esper's entities, if any have been accessed, match the living organisms."""
        registry = self.world.context.registry
        for table in self.world.tables.values():
            for row, number, entity in registry.met(table):
                owner = owner_of(table.uid, row)
                for component, handle in dict.items(entity):
                    if component in table.columns and (
                        handle._row != row or getattr(handle._columns, "_table", None) is not table
                    ):
                        self.fail(
                            table,
                            f"{component.__name__} of esper's entity {number} is not the component of "
                            f"{owner}; write into its fields instead of replacing or removing it",
                        )

    def _finite(self, table: Table) -> None:
        for component, name, array in columns(table):
            if array.dtype.kind != "f" or _all_finite(array):
                continue
            rows = table.rows()
            values = array[rows].reshape(rows.size, -1)
            if (bad := np.argwhere(~np.isfinite(values))).size:
                i, j = bad[0]
                entry = ", ".join(map(str, np.unravel_index(j, array.shape[1:])))
                at = f"[{entry}]" if len(array.shape) > 1 else ""
                self.fail(
                    table,
                    f"{component.__name__}.{name}{at} of {owner_of(table.uid, rows[i])} is "
                    f"{values[i, j]}"
                    f"{more(len(np.unique(bad[:, 0])))}; expected finite numbers",
                )

    def _bounds(self, table: Table) -> None:
        places = {n: a for c, n, a in columns(table) if c.__name__ == "Position"}
        space = self.world.space
        for axis, length in zip("xyz"[: len(space.size)], space.lengths, strict=False):
            if axis in places:
                inside = (places[axis] >= 0) & (places[axis] < length)
                self._within(table, axis, places[axis], inside, f"[0, {length:g})")
        if "heading" in places:
            h = places["heading"]
            self._within(table, "heading", h, (h > -1e-5) & (h < FULL_TURN + 1e-5), "[0, 2π)")

    def _within(self, table: Table, name: str, column: np.ndarray, inside: np.ndarray, allowed: str) -> None:
        if (rows := np.flatnonzero(table.alive & ~inside)).size:
            self.fail(
                table,
                f"Position.{name} of {owner_of(table.uid, rows[0])} is "
                f"{column[rows[0]]}{more(rows.size)}; expected {allowed}",
            )

    def _resolution(self, table: Table) -> None:
        """Check that changes in energy and position are not lost to rounding at the current values."""
        dt, rows = np.float32(self.world.dt), table.rows()
        basal = np.float32(table.species.metabolism.basal) * dt
        if basal > 0 and Metabolism in table:
            energy = table[Metabolism].energy[rows]
            lost = (energy - basal == energy) & np.isfinite(energy)
            self._lost(table, rows, "Metabolism.energy", energy, lost, basal)
        gaits = table.species.gaits
        speeds = [] if gaits is None else [v for v in gaits[1] * dt if v > 0]
        for axis in "xy" if speeds and Position in table else "":
            place = getattr(table[Position], axis)[rows]
            self._lost(table, rows, f"Position.{axis}", place, place + min(speeds) == place, min(speeds))

    def _lost(
        self, table: Table, rows: np.ndarray, name: str, values: np.ndarray, lost: np.ndarray, step: Any
    ) -> None:
        if (at := np.flatnonzero(lost)).size:
            least = np.spacing(np.abs(values[at[0]]))
            self.fail(
                table,
                f"{name} of {owner_of(table.uid, rows[at[0]])} is {values[at[0]]}{more(at.size)}, "
                f"where a step of {step:g} is lost to rounding; the smallest float32 step there is "
                f"{least:g}",
            )

    def _nerves(self, table: Table) -> None:
        nerves = table.species.nerves
        x, rows, brain = (getattr(nerves, name, None) for name in ("x", "rows", "brain"))
        if x is not None and rows is not None and not np.isfinite(x).all():
            bad = np.argwhere(~np.isfinite(x))
            i, j = bad[0].tolist()
            self.fail(
                table,
                f"the reading {nerves.channels[j]!r} of {owner_of(table.uid, rows[i])} is "
                f"{x[i, j]}{more(len(np.unique(bad[:, 0])))}; expected finite numbers",
            )
        if brain is not None:
            for name, w in brain.named().items():
                if not np.isfinite(w).all():
                    bad = np.argwhere(~np.isfinite(w))
                    self.fail(
                        table,
                        f"weight {name}{bad[0].tolist()} of the policy is "
                        f"{w[tuple(bad[0])]}{more(len(bad))}; expected finite numbers",
                    )

    def _index(self, table: Table) -> None:
        index = self.world._indexes.get(table.name)
        if index is None or index.version != table.version or index.space is not self.world.space:
            return
        cell = np.repeat(np.arange(index.space.n_cells), np.diff(index.start))
        if index.n != table.n or cell.size != index.n or (table.uid[index.rows] != index.uid).any():
            self.fail(
                table,
                f"the neighbor index has {index.n} entries, which do not match the {table.n} living "
                "organisms; systems may only read the index",
            )
        back = np.flatnonzero((np.diff(cell) == 0) & (index.uid[1:] <= index.uid[:-1]))
        if back.size:
            i = back[0] + 1
            self.fail(
                table,
                f"entry {i} of the neighbor index, uid {index.uid[i]}, "
                f"follows uid {index.uid[i - 1]} in the same cell; systems may only read the index",
            )


def _all_finite(array: np.ndarray | Blocked) -> bool:
    return all(np.isfinite(part).all() for part in (array.blocks if isinstance(array, Blocked) else [array]))
