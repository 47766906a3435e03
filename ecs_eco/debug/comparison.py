"""Checks of the changes made by one system or flush: the world is copied before and compared afterward."""

from __future__ import annotations

import esper
import numpy as np

from ecs_eco.debug.columns import IDENTITY, budget, bytes_of, columns, more, owner_of
from ecs_eco.debug.invariants import Invariants
from ecs_eco.engine.system import System
from ecs_eco.engine.table import Table
from ecs_eco.record.ledger import FLOWS, LEDGER, imbalance
from ecs_eco.record.recorder import Recorder
from ecs_eco.space.world import SpatialWorld
from ecs_eco.systems import ResetFlows

# tolerance of a float32 sum relative to its largest term: 8 units in the last place
ROUNDING = np.float32(1e-6)


class Snapshot:
    """A table before a system acts: identities, counts, shapes, and copied positions, energy and free rows."""

    def __init__(self, table: Table) -> None:
        self.identity = {name: getattr(table, name).copy() for name in IDENTITY}
        self.counts, self.version = (table.n, table.high), table.version
        self.free = np.flatnonzero(~table.alive)
        self.shapes, self.empty, self.places = {}, {}, {}
        for component, name, array in columns(table):
            self.shapes[component, name] = array.dtype, array.shape
            self.empty[component, name] = array[self.free]
            if component.__name__ == "Position":
                self.places[name] = array.copy()
        self.budget = {name: array.copy() for name, array in budget(table).items()}


class Before:
    """The world before a system acts, for comparison with the world afterward."""

    def __init__(self, world: SpatialWorld, name: str, system: esper.Processor | None, flush: bool) -> None:
        self.world, self.name, self.system, self.flush = world, name, system, flush
        self.invariants = Invariants(world, name, system)
        self.fail = self.invariants.fail
        self.tables = {table.name: Snapshot(table) for table in world.tables.values()}
        self.page = system._at if isinstance(system, Recorder) else None

    def compare(self) -> None:
        """Check the world after the system has acted."""
        pairs = [(t, self.tables[t.name]) for t in self.world.tables.values() if t.name in self.tables]
        for table, before in pairs if not self.flush else ():
            self._identities(table, before)
            self._shapes(table, before)
        self.invariants.check()
        for table, before in pairs:
            self._free_rows(table, before)
            self._moved(table, before)
            self._energy(table, before)
        self._ledger()

    def _identities(self, table: Table, before: Snapshot) -> None:
        for column in IDENTITY:
            was, now = before.identity[column], getattr(table, column)
            if was.shape != now.shape:
                self.fail(
                    table,
                    f"{column} has {len(now)} rows and had {len(was)}; births add rows only at the "
                    "end of `reproduce`",
                )
            if (rows := np.flatnonzero(was != now)).size:
                r = rows[0]
                owner = owner_of(before.identity["uid"], r)
                self.fail(
                    table,
                    f"{column} of {owner} was {was[r]} and is {now[r]}{more(rows.size)}; request "
                    "births and deaths with table.request, world.spawn, table.cause or world.kill",
                )
        if before.counts != (table.n, table.high):
            self.fail(
                table,
                f"(n, high) was {before.counts} and is {(table.n, table.high)}; only "
                "births and deaths may change it",
            )

    def _shapes(self, table: Table, before: Snapshot) -> None:
        now = {(c, n): (a.dtype, a.shape) for c, n, a in columns(table)}
        for (component, name), was in before.shapes.items():
            if (shape := now.get((component, name))) != was and component in table:
                is_now = "gone" if shape is None else f"{shape[0]}{list(shape[1])}"
                self.fail(
                    table,
                    f"column {component.__name__}.{name} was {was[0]}{list(was[1])} and is "
                    f"{is_now}; write into the column: table[{component.__name__}].{name}[rows] = …",
                )

    def _free_rows(self, table: Table, before: Snapshot) -> None:
        free = before.free
        free = free[~table.alive[free]]
        still = ~table.alive[before.free]
        for component, name, array in columns(table):
            was = before.empty.get((component, name))
            if was is None or was.shape[1:] != array.shape[1:]:
                continue
            now_free, kept = array[free], was if still.all() else was[still]
            if now_free.tobytes() == kept.tobytes():
                continue
            now, old = bytes_of(now_free), bytes_of(kept)
            wrong = (now != old).any(axis=1) & now.any(axis=1)  # a system may clear a free row
            if wrong.any():
                i = int(np.flatnonzero(wrong)[0])
                self.fail(
                    table,
                    f"{component.__name__}.{name} of row {free[i]}, which is free, "
                    f"was {kept[i]} and is {now_free[i]}{more(int(wrong.sum()))}; "
                    "write only to living rows: table.rows() or table.alive",
                )

    def _moved(self, table: Table, before: Snapshot) -> None:
        """Check that the neighbor index was invalidated if positions changed; plain processors are exempt."""
        if table.version != before.version or (
            self.system is not None and not isinstance(self.system, System)
        ):
            return
        for name, was in before.places.items():
            now = getattr(next(c for k, c in table.columns.items() if k.__name__ == "Position"), name)
            if (
                name != "heading"
                and was.shape == now.shape
                and (rows := np.flatnonzero((was != now) & table.alive)).size
            ):
                r = rows[0]
                self.fail(
                    table,
                    f"Position.{name} of {owner_of(table.uid, r)} was {was[r]} and is "
                    f"{now[r]}{more(rows.size)}, but table.version is the same; "
                    "add `table.version += 1`, so that the neighbor index is updated",
                )

    def _energy(self, table: Table, before: Snapshot) -> None:
        was, now = before.budget, budget(table)
        if not was or not now or not any(isinstance(s, ResetFlows) for s in self.world.systems):
            return  # without ResetFlows there is no ledger
        n = min(len(was["energy"]), len(now["energy"]))
        alive, uid = before.identity["alive"][:n], before.identity["uid"][:n]
        rows = np.flatnonzero(table.alive[:n] & alive & (table.uid[:n] == uid))
        opens = isinstance(self.system, ResetFlows)  # a new ledger page: all flows are zero
        if all(was[n][rows].tobytes() == now[n][rows].tobytes() for n in was):
            return
        was, now = ({n: a[rows].astype(float) for n, a in book.items()} for book in (was, now))
        if opens:
            was |= dict.fromkeys(FLOWS.values(), np.zeros(rows.size))
        gained = now["energy"] - was["energy"]
        booked = sum(
            sign * (now[flow] - was[flow]) for flow, sign in zip(FLOWS.values(), (1, -1, -1), strict=True)
        )
        scale = np.max([np.abs(a) for book in (was, now) for a in book.values()], axis=0)
        gap = gained - booked
        # energy passed between two organisms cancels out in the sum
        gap[~(np.abs(gap) > ROUNDING * scale)] = 0.0
        off, room = gap.sum(), float((ROUNDING * scale)[gap != 0].sum())
        if abs(off) > room:
            i = int(np.abs(gap).argmax())
            owner = owner_of(table.uid, rows[i])
            came = "appeared without a source" if off > 0 else "disappeared without a sink"
            self.fail(
                table,
                f"energy {came}: the organisms' energy changed by {gained.sum():.6g}, but taken − "
                f"burnt − given by {booked.sum():.6g}, a difference of {abs(off):.6g}; the largest "
                f"gap, {gap[i]:.6g}, is in {owner}, with Metabolism.energy {was['energy'][i]:.6g} before and "
                f"{now['energy'][i]:.6g} after; add it to taken, burnt or given",
            )

    def _ledger(self) -> None:
        """Check that the ledger page just written by the recorder balances."""
        recorder, at = self.system, self.page
        if not isinstance(recorder, Recorder) or at is None or recorder._at != at + 1:
            return
        for s, name in enumerate(recorder.names):
            page, table = recorder._ledger[at, s], self.world.tables[name]
            apart = imbalance(page) + self.world.debug.drift.get(name, 0.0)
            size = (
                sum(abs(page[column]) for column in LEDGER)
                + np.abs(budget(table).get("energy", np.zeros(1))).sum()
            )
            if abs(apart) > 1e-5 * size + 1e-9:
                self.fail(
                    table,
                    "the energy ledger does not close: stock_before {stock_before:.6g} + "
                    "endowed {endowed:.6g} + taken_in {taken_in:.6g} − burnt {burnt:.6g} − "
                    "given {given:.6g} − lost {lost:.6g} is not stock_after "
                    "{stock_after:.6g}".format(**{column: page[column] for column in LEDGER})
                    + f", a difference of {abs(apart):.6g}; the cause is a death or a birth, not a system",
                )
