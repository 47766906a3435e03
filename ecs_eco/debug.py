"""Debug mode, ECS_ECO_DEBUG=1: checks after each system, too slow to be always on; they change no result.

What outsiders may write into a world is looked at always, in `ecs_eco.space.gate`. See docs/debugging.md.
"""

from __future__ import annotations

import os
import weakref
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NoReturn

import esper
import numpy as np

from ecs_eco.engine.blocks import Blocked
from ecs_eco.engine.schema import Columns
from ecs_eco.engine.system import System
from ecs_eco.record.ledger import FLOWS, LEDGER, imbalance

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

WHO = ("alive", "uid", "born")  # what flushes alone change
ROUNDING = np.float32(1e-6)  # [1] of the largest number of a sum in float32: 8 units in the last place
FULL_TURN = 6.2831855  # [rad]
BETWEEN = "what was done between ticks"


class DebugError(RuntimeError):
    """A check of the debug mode that failed: the system, the tick, the species, the column, the organism and the value."""


class StaleHandle(DebugError):
    """A handle that was kept past its owner's death."""


def start(world: SpatialWorld) -> Debug | None:
    """Return the checks of a new world where the environment asks for them: ECS_ECO_DEBUG is set, and not to 0; else None."""
    return None if os.environ.get("ECS_ECO_DEBUG", "0") in ("", "0") else Debug(world)


class Guard(Columns):
    """One organism's columns, as its handle sees them in debug mode: every access asks whether the row is still its own."""

    __slots__ = ("_component", "_row", "_table", "_uid")
    __setattr__ = object.__setattr__  # type: ignore[assignment]  # it holds no columns of its own

    def __init__(self, table: Table, component: type[Any], row: int, uid: int) -> None:
        table[component]  # raises the error that names what there is
        self._table, self._component, self._row, self._uid = table, component, row, int(uid)

    def __getattr__(self, name: str) -> Any:
        table, row, uid = self._table, self._row, self._uid
        if table.uid[row] != uid:
            here = int(table.uid[row])
            now = f"row {row} belongs to uid {here} now" if here else f"row {row} is free now"
            fate = f"uid {uid} is dead, and {now}; keep uids and ask world.get again" if not (table.uid == uid).any() else (
                f"uid {uid} is no longer in row {row}: rows were reordered; ask world.get again")
            raise StaleHandle(f"tables[{table.name!r}]: {self._component.__name__}.{name} through a handle kept too long: {fate}")
        return getattr(table.columns[self._component], name)

    @property
    def __dict__(self) -> dict[str, Any]:  # type: ignore[override]
        return {name: getattr(self, name) for name in self._component.fields}


class Debug:
    """The checks of one world. Its systems and its flushes pass through `watch`."""

    def __init__(self, world: SpatialWorld) -> None:
        self.world = weakref.proxy(world)
        self.before: Before | None = None  # the system under way began
        self.drift: dict[str, float] = {}  # energy of a species that changed between ticks: no ledger has it
        kind, proxy = type(world), self.world
        for name, what in (("flush_deaths", "the deaths of the phase die"), ("flush_births", "the births of the phase reproduce")):
            flush = getattr(kind, name)
            setattr(world, name, lambda flush=flush, what=what: self.watch(what, lambda: flush(proxy), flush=True))
        world.context.add(Opening(world), "environment", 0)

    def guard(self, table: Table, component: type[Any], row: int) -> Guard:
        """Return what stands for the columns of a component in the handle of one row."""
        return Guard(table, component, row, int(table.uid[row]))

    def follow(self, system: esper.Processor) -> None:
        """Check after each time that this system acts."""
        act, name = system.process, type(system).__name__
        system.process = lambda *args, **kwargs: self.watch(name, lambda: act(*args, **kwargs), system)  # type: ignore[method-assign]

    def watch(self, name: str, act: Callable[[], None], system: Any = None, flush: bool = False) -> None:
        """Let a system, or a flush, act, and check what it did; a flush within a system divides what that did in two."""
        outer = self.before
        if outer is not None:
            outer.compare()
        elif not self.world.ticking:
            Before(self.world, BETWEEN, None, True).check()
        self.before = Before(self.world, name, system, flush)
        try:
            act()
            self.before.compare()
            if outer is not None:
                outer = Before(self.world, outer.name, outer.system, outer.flush)
        except BaseException:
            outer = None
            raise
        finally:
            self.before = outer


class Opening(esper.Processor):
    """The first of a tick: what was done between ticks is checked under that name, not the first system's."""

    def __init__(self, world: SpatialWorld) -> None:
        self.world = weakref.proxy(world)

    def process(self, *_: Any) -> None:
        """Check the world as the tick finds it, and note what the ledger of this tick cannot know."""
        Before(self.world, BETWEEN, None, True).check()
        recorder = self.world.recorder
        for s, name in enumerate(recorder.names if recorder is not None else ()):
            page, energy = recorder._ledger[recorder._at, s], _budget(table := self.world.tables[name]).get("energy")
            stock = 0.0 if energy is None else energy[table.rows()].sum(dtype=np.float64)
            self.world.debug.drift[name] = stock - (recorder._stock[s] + page["endowed"] - page["lost"])


class Before:
    """The world as one system found it, and the comparison with what the system leaves."""

    def __init__(self, world: SpatialWorld, name: str, system: Any, flush: bool) -> None:
        self.world, self.name, self.system, self.flush = world, name, system, flush
        self.who = {t.name: {c: getattr(t, c).copy() for c in WHO} for t in world.tables.values()}
        self.counts = {t.name: (t.n, t.high, t.version) for t in world.tables.values()}
        self.shapes = {t.name: {(c, n): (a.dtype, a.shape) for c, n, a in _columns(t)} for t in world.tables.values()}
        self.free = {t.name: np.flatnonzero(~t.alive) for t in world.tables.values()}
        self.empty = {t.name: {(c, n): a[self.free[t.name]] for c, n, a in _columns(t)} for t in world.tables.values()}
        self.places = {t.name: {n: a.copy() for c, n, a in _columns(t) if c.__name__ == "Position"} for t in world.tables.values()}
        self.budget = {t.name: {n: a.copy() for n, a in _budget(t).items()} for t in world.tables.values()}
        self.page = _page(system)

    def fail(self, table: Table | None, what: str, kind: type[DebugError] = DebugError) -> NoReturn:
        """Raise with the place: the system, the tick, the species."""
        where = "" if table is None else f", {'objects' if table.species.is_object else 'species'} {table.name!r}"
        raise kind(f"after {self.name}, tick {self.world.tick}{where}: {what}")

    def compare(self) -> None:
        """Check the world as the system leaves it."""
        for table in self.world.tables.values():
            if table.name in self.who:
                if not self.flush:
                    self._identities(table)
                    self._shapes(table)
        self.check()
        for table in self.world.tables.values():
            if table.name in self.who:
                self._free_rows(table)
                self._moved(table)
                self._energy(table)
        self._ledger()

    def check(self) -> None:
        """Check what must hold at any time."""
        for table in self.world.tables.values():
            self._living(table)
            self._finite(table)
            self._bounds(table)
            self._nerves(table)
            self._index(table)
            self._resolution(table)
        self._uids()
        for name, field in self.world.fields.items():
            if (bad := np.argwhere(~np.isfinite(field.value))).size:
                self.fail(None, f"field {name!r} is {field.value[tuple(bad[0])]} in the cell (z, y, x) = {tuple(bad[0].tolist())}"
                                f"{_more(len(bad))}; allowed are finite numbers")
        if self.system is not None and not isinstance(self.system, System):
            self._registry()

    # --- who lives ---------------------------------------------------------------------------------------------------

    def _identities(self, table: Table) -> None:
        for column in WHO:
            was, now = self.who[table.name][column], getattr(table, column)
            if was.shape != now.shape:
                self.fail(table, f"{column} has {len(now)} rows and had {len(was)}; births make room at the end of `reproduce`")
            if (rows := np.flatnonzero(was != now)).size:
                r = rows[0]
                self.fail(table, f"{column} of {_whose(self.who[table.name]['uid'], r)} was {was[r]} and is {now[r]}{_more(rows.size)}; "
                                 "births and deaths are asked for: table.request, world.spawn, table.cause, world.kill")
        if self.counts[table.name][:2] != (table.n, table.high):
            self.fail(table, f"(n, high) was {self.counts[table.name][:2]} is {(table.n, table.high)}; births and deaths alone change it")

    def _living(self, table: Table) -> None:
        if table.n != np.count_nonzero(table.alive) or table.alive[table.high :].any():
            self.fail(table, f"n is {table.n} and high {table.high}, but {np.count_nonzero(table.alive)} rows are alive")
        for name, wrong, what in (("uid", table.alive & (table.uid == 0), "lives and has none"),
                                  ("uid", ~table.alive & (table.uid != 0), "is free and has one"),
                                  ("cause", ~table.alive & (table.cause != 0), "is free: who lives dies")):
            if (rows := np.flatnonzero(wrong)).size:
                self.fail(table, f"{name} of row {rows[0]} is {getattr(table, name)[rows[0]]}; the row {what}{_more(rows.size)}")

    def _uids(self) -> None:
        seen: dict[int, str] = {}
        tables = list(self.world.tables.values())
        uid = np.concatenate([t.uid[t.alive] for t in tables]) if tables else np.zeros(0, np.uint64)
        uid.sort()
        if not uid.size or (uid[-1] < self.world.next_uid and (uid[1:] != uid[:-1]).all()):
            return
        for table in tables:
            for row in table.rows():
                u = int(table.uid[row])
                if u in seen:
                    self.fail(table, f"uid {u} lives in row {row} and in {seen[u]}; a uid is given once")
                if u >= self.world.next_uid:
                    self.fail(table, f"uid {u} lives in row {row}, but the next to be given is {self.world.next_uid}")
                seen[u] = f"row {row} of {table.name!r}"

    def _registry(self) -> None:
        """Compare esper's entities with those living: only after plain processors, before which they are brought up to date."""
        for table in self.world.tables.values():
            for row in np.flatnonzero(table.alive & (table.entity_uid == table.uid)):
                entity, whose = int(table.entity[row]), _whose(table.uid, row)
                if not esper.entity_exists(entity):
                    self.fail(table, f"esper has no entity {entity}, but {whose} lives; to kill it, world.kill(uid, cause)")
                for component in table.columns:
                    handle = esper.try_component(entity, component)
                    if handle is None or handle._row != row or getattr(handle._columns, "_table", None) is not table:
                        self.fail(table, f"{component.__name__} of esper's entity {entity} is not that of {whose}; "
                                         "write into its fields, and do not replace or remove it")

    # --- what they have ----------------------------------------------------------------------------------------------

    def _shapes(self, table: Table) -> None:
        now = {(c, n): (a.dtype, a.shape) for c, n, a in _columns(table)}
        for (component, name), was in self.shapes[table.name].items():
            if (found := now.get((component, name))) != was and component in table:
                is_now = "gone" if found is None else f"{found[0]}{list(found[1])}"
                self.fail(table, f"column {component.__name__}.{name} was {was[0]}{list(was[1])} and is {is_now}; "
                                 f"write into it: table[{component.__name__}].{name}[rows] = …")

    def _free_rows(self, table: Table) -> None:
        free = self.free[table.name]
        free = free[~table.alive[free]]
        if not free.size:
            return
        still = ~table.alive[self.free[table.name]]
        for component, name, array in _columns(table):
            was = self.empty[table.name].get((component, name))
            if was is None or was.shape[1:] != array.shape[1:]:
                continue
            found, kept = array[free], was if still.all() else was[still]
            if found.tobytes() == kept.tobytes():
                continue
            now, old = _bytes(found), _bytes(kept)
            wrong = (now != old).any(axis=1) & now.any(axis=1)  # clearing a free row is nobody's loss
            if wrong.any():
                i = int(np.flatnonzero(wrong)[0])
                self.fail(table, f"{component.__name__}.{name} of row {free[i]}, which is free, was {kept[i]} and is "
                                 f"{found[i]}{_more(int(wrong.sum()))}; write to the living only: table.rows() or table.alive")

    def _finite(self, table: Table) -> None:
        for component, name, array in _columns(table):
            if array.dtype.kind != "f" or _all_finite(array):
                continue
            rows = table.rows()
            values = array[rows].reshape(rows.size, -1)
            if (bad := np.argwhere(~np.isfinite(values))).size:
                i, j = bad[0]
                at = f"[{', '.join(map(str, np.unravel_index(j, array.shape[1:])))}]" if len(array.shape) > 1 else ""
                self.fail(table, f"{component.__name__}.{name}{at} of {_whose(table.uid, rows[i])} is {values[i, j]}"
                                 f"{_more(len(np.unique(bad[:, 0])))}; allowed are finite numbers")

    def _bounds(self, table: Table) -> None:
        places = {n: a for c, n, a in _columns(table) if c.__name__ == "Position"}
        space = self.world.space
        for axis, length in zip("xyz"[: len(space.size)], space.lengths, strict=False):
            if axis in places:
                self._within(table, f"Position.{axis}", places[axis], table.alive & ~((places[axis] >= 0) & (places[axis] < length)),
                             f"[0, {length:g})")
        if "heading" in places:
            h = places["heading"]
            self._within(table, "Position.heading", h, table.alive & ~((h > -1e-5) & (h < FULL_TURN + 1e-5)), "[0, 2π)")

    def _within(self, table: Table, name: str, column: np.ndarray, wrong: np.ndarray, allowed: str) -> None:
        if (rows := np.flatnonzero(wrong)).size:
            self.fail(table, f"{name} of {_whose(table.uid, rows[0])} is {column[rows[0]]}{_more(rows.size)}; allowed is {allowed}")

    def _resolution(self, table: Table) -> None:
        """See that the steps of energy and place are not rounded away where the organisms have come to."""
        from ecs_eco.components import Metabolism, Position

        dt, species, rows = np.float32(self.world.dt), table.species.config, table.rows()
        basal = np.float32(species.metabolism.basal if species is not None else 0) * dt
        if basal > 0 and Metabolism in table:
            energy = table[Metabolism].energy[rows]
            self._lost(table, rows, "Metabolism.energy", energy, (energy - basal == energy) & np.isfinite(energy), basal)
        speeds = [v for v in (table.species.gaits[1] * dt if table.species.gaits is not None else ()) if v > 0]
        for axis in "xy" if speeds and Position in table else "":
            place = getattr(table[Position], axis)[rows]
            self._lost(table, rows, f"Position.{axis}", place, place + min(speeds) == place, min(speeds))

    def _lost(self, table: Table, rows: np.ndarray, name: str, values: np.ndarray, lost: np.ndarray, step: Any) -> None:
        if (at := np.flatnonzero(lost)).size:
            least = np.spacing(np.abs(values[at[0]]))
            self.fail(table, f"{name} of {_whose(table.uid, rows[at[0]])} is {values[at[0]]}{_more(at.size)}, and a step of {step:g} is "
                             f"rounded away there; float32 holds steps of {least:g} and more")

    def _moved(self, table: Table) -> None:
        """See that the index is made anew where places changed; plain processors need not say so."""
        if table.version != self.counts[table.name][2] or (self.system is not None and not isinstance(self.system, System)):
            return
        for name, was in self.places[table.name].items():
            now = getattr(next(c for k, c in table.columns.items() if k.__name__ == "Position"), name)
            if name != "heading" and was.shape == now.shape and (rows := np.flatnonzero((was != now) & table.alive)).size:
                r = rows[0]
                self.fail(table, f"Position.{name} of {_whose(table.uid, r)} was {was[r]} and is {now[r]}{_more(rows.size)}, "
                                 "but table.version is the same; say `table.version += 1`, or neighbours are looked for where they were")

    def _nerves(self, table: Table) -> None:
        nerves = table.species.nerves
        x, rows, brain = getattr(nerves, "x", None), getattr(nerves, "rows", None), getattr(nerves, "brain", None)
        if x is not None and rows is not None and not np.isfinite(x).all():
            bad = np.argwhere(~np.isfinite(x))
            i, j = bad[0].tolist()
            self.fail(table, f"the reading {nerves.channels[j]!r} of {_whose(table.uid, rows[i])} is {x[i, j]}"
                             f"{_more(len(np.unique(bad[:, 0])))}; allowed are finite numbers")
        if brain is not None:
            for name, tensor in brain.named().items():
                if not np.isfinite(w := tensor.numpy()).all():
                    bad = np.argwhere(~np.isfinite(w))
                    self.fail(table, f"weight {name}{bad[0].tolist()} of the policy is {w[tuple(bad[0])]}{_more(len(bad))}; "
                                     "allowed are finite numbers")

    def _index(self, table: Table) -> None:
        index = self.world._indexes.get(table.name)
        if index is None or index.version != table.version or index.space is not self.world.space:
            return
        cell = np.repeat(np.arange(index.space.n_cells), np.diff(index.start))
        if index.n != table.n or cell.size != index.n or (table.uid[index.rows] != index.uid).any():
            self.fail(table, f"the index of neighbours holds {index.n} entries that are not the {table.n} living; systems only read it")
        back = np.flatnonzero((np.diff(cell) == 0) & (index.uid[1:] <= index.uid[:-1]))
        if back.size:
            i = back[0] + 1
            self.fail(table, f"entry {i} of the index of neighbours, uid {index.uid[i]}, follows uid {index.uid[i - 1]} in one cell; "
                             "systems only read it")

    # --- energy ------------------------------------------------------------------------------------------------------

    def _energy(self, table: Table) -> None:
        from ecs_eco.systems import ResetFlows

        was, now = self.budget[table.name], _budget(table)
        if not was or not now or not any(isinstance(s, ResetFlows) for s in self.world.systems):
            return  # without ResetFlows nobody keeps books
        n = min(len(was["energy"]), len(now["energy"]))
        same = table.alive[:n] & self.who[table.name]["alive"][:n] & (table.uid[:n] == self.who[table.name]["uid"][:n])
        rows = np.flatnonzero(same)
        opens = isinstance(self.system, ResetFlows)  # a new page: all flows are zero
        if all(was[n][rows].tobytes() == now[n][rows].tobytes() for n in was):
            return
        was, now = ({n: a[rows].astype(float) for n, a in book.items()} for book in (was, now))
        if opens:
            was |= dict.fromkeys(FLOWS.values(), np.zeros(rows.size))
        gained = now["energy"] - was["energy"]
        booked = sum(sign * (now[flow] - was[flow]) for flow, sign in zip(FLOWS.values(), (1, -1, -1), strict=True))
        scale = np.max([np.abs(a) for book in (was, now) for a in book.values()], axis=0)
        gap = gained - booked
        gap[~(np.abs(gap) > ROUNDING * scale)] = 0.0  # what moves between two organisms is in both, and not in the sum
        off, room = gap.sum(), float((ROUNDING * scale)[gap != 0].sum())
        if abs(off) > room:
            i = int(np.abs(gap).argmax())
            whose, came = _whose(table.uid, rows[i]), "came from nothing" if off > 0 else "went to nowhere"
            self.fail(table, f"energy {came}: that of all living changed by {gained.sum():.6g}, but taken − burnt − given by "
                             f"{booked.sum():.6g}, {abs(off):.6g} apart; the largest gap, {gap[i]:.6g}, is that of {whose}, "
                             f"Metabolism.energy {was['energy'][i]:.6g} to {now['energy'][i]:.6g}; book it in taken, burnt or given")

    def _ledger(self) -> None:
        """See that the page that the recorder has just written closes."""
        if self.page is None or self.system._at != self.page + 1:
            return
        at = self.page
        for s, name in enumerate(self.system.names):
            page, table = self.system._ledger[at, s], self.world.tables[name]
            apart = imbalance(page) + self.world.debug.drift.get(name, 0.0)
            size = sum(abs(page[column]) for column in LEDGER) + np.abs(_budget(table).get("energy", np.zeros(1))).sum()
            if abs(apart) > 1e-5 * size + 1e-9:
                self.fail(table, "the energy ledger does not close: stock_before {stock_before:.6g} + endowed {endowed:.6g} + "
                          "taken_in {taken_in:.6g} − burnt {burnt:.6g} − given {given:.6g} − lost {lost:.6g} is not "
                          "stock_after {stock_after:.6g}".format(**{column: page[column] for column in LEDGER})
                          + f", {abs(apart):.6g} apart; no system did it: a death or a birth did")


def _columns(table: Table) -> Iterator[tuple[Any, str, Any]]:
    for component, columns in table.columns.items():
        for name, array in vars(columns).items():
            yield component, name, array


def _budget(table: Table) -> dict[str, np.ndarray]:
    """Return energy and flows of a table with Metabolism; nothing of another."""
    from ecs_eco.components import Metabolism

    return {n: getattr(table[Metabolism], n) for n in ("energy", *FLOWS.values())} if Metabolism in table else {}


def _page(system: Any) -> int | None:
    """Return the page of the ledger that a recorder is about to write; None of another system."""
    from ecs_eco.record.recorder import Recorder

    return system._at if isinstance(system, Recorder) else None


def _all_finite(array: Any) -> bool:
    return all(np.isfinite(part).all() for part in (array.blocks if isinstance(array, Blocked) else [array]))


def _bytes(array: np.ndarray) -> np.ndarray:
    """Return the rows of an array as bytes u8[n, …]; NaN is then itself, and no number is 0 but 0."""
    array = np.ascontiguousarray(array)
    return array.reshape(len(array), -1).view(np.uint8).reshape(len(array), -1)


def _whose(uid: np.ndarray, row: Any) -> str:
    return f"uid {int(uid[row])} (row {int(row)})" if uid[row] else f"row {int(row)}, which is free,"


def _more(n: int) -> str:
    return f" ({n - 1} more)" if n > 1 else ""
