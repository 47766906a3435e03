"""One world's entities as esper sees them, created and updated on access."""

from __future__ import annotations

import itertools
import weakref
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from ecs_eco.compiled.garbage import uncollected
from ecs_eco.engine.errors import listed
from ecs_eco.engine.interruption import require_whole, whole
from ecs_eco.engine.living import LivingWorld
from ecs_eco.engine.schema import Handle
from ecs_eco.esper_bridge.doors import Cache, Components, Dead, Entities, Events, Kinds, Processors
from ecs_eco.esper_bridge.entity import WAITING, Entity, name_of

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

NUMBER, UID = "esper's number", "whose it is"  # arrays that move with a table's rows


class Registry:
    """Everything that esper stores for one world, and a weak reference to that world."""

    def __init__(self, world: LivingWorld) -> None:
        self.world: Any = weakref.ref(world)
        self.numbers = Numbers()
        self.components, self.entities, self.dead = Components(), Entities(), Dead()
        self.caches = Cache(), Cache()
        self.processors, self.kinds = Processors(), Kinds()
        self.events = Events()
        # whether births, deaths or moves have happened since the last update
        self.stale = False
        self.renewed: set[str] = set()  # tables whose rows or columns have changed since the last update
        self.places: dict[str, tuple[np.ndarray, np.ndarray]] = {}  # by table: ascending numbers, their rows
        self.looked_at: tuple[int, Table, int] | None = None  # the current entity in esper's loop
        self.waiting: dict[int, Entity] = {}  # unborn entities, by the id of their birth request
        parts: tuple[Any, ...] = (
            self.components,
            self.entities,
            self.dead,
            *self.caches,
            self.processors,
            self.kinds,
            self.events,
        )
        for part in parts:
            part.registry = self
        # the state of a context, as `esper.switch_world` stores it
        self.state = self.numbers, *parts[:-1], False, {}, self.events

    @property
    def called(self) -> str:
        """The world's name, for messages."""
        world = self.world()
        return "a deleted world" if world is None else f"world {world.name!r}"

    def refuse(self, function: str, why: str) -> NoReturn:
        """Raise an error for an esper function that is not available here."""
        raise RuntimeError(f"esper.{function}, {self.called}: {why}")

    # --- entities -------------------------------------------------------------------------------------------

    def join(self, table: Table) -> None:
        """Add two arrays to a table: each row's entity number, which is local to the process, and uid."""
        table.along[NUMBER] = np.zeros(table.capacity, np.int64)
        table.along[UID] = np.zeros(table.capacity, np.uint64)
        table.onlooker = self

    def renew(self, table: Table) -> None:
        """Mark handles as outdated because rows or columns of a table have changed."""
        self.renewed.add(table.name)
        self.stale = True

    def strike(self, kind: type, number: int) -> None:
        """Remove an entity from the set of entities with a plain component."""
        if (numbers := dict.get(self.components, kind)) is not None:
            numbers.discard(number)
            if not numbers:
                del self.components[kind]

    def refresh(self) -> None:
        """Update esper's entities if the tables have changed."""
        if self.stale and (world := self.world()) is not None:
            world.sync()

    def sync(self, tables: Iterable[Table]) -> None:
        """Give each living organism an entity number; everything else is created on access."""
        self.stale = False
        for table in tables:
            entity, owner = table.along[NUMBER], table.along[UID]
            rows = np.flatnonzero(owner != table.uid)
            if not rows.size and table.name not in self.renewed:
                continue
            for number in entity[rows[owner[rows] != 0]].tolist():
                self._drop(number)
            living = rows[table.uid[rows] != 0]
            entity[rows] = 0
            entity[living] = self.numbers.take(living.size)
            owner[rows] = table.uid[rows]
            if table.name in self.renewed:
                self.renewed.discard(table.name)
                self._settle(table)
            self._changed()

    def number(self, table: Table, row: int) -> int:
        """Return the number of a row's living entity, assigning one if it has none."""
        if table.along[UID][row] != table.uid[row]:
            self._drop(int(table.along[NUMBER][row]))
            table.along[NUMBER][row], table.along[UID][row] = next(self.numbers), table.uid[row]
            self._changed()
        number = int(table.along[NUMBER][row])
        if self.held(number) is None:
            self._make(number, table, row)
        return number

    def held(self, number: int) -> Entity | None:
        """Return the entity object with a number without updating anything."""
        return dict.get(self.entities, number)

    def plain(self, table: Table, rows: np.ndarray) -> Iterator[tuple[int, Any]]:
        """Yield (uid, component) for all components of living entities that are not columns."""
        for row in rows[table.along[NUMBER][rows] != 0].tolist():
            entity = self.held(int(table.along[NUMBER][row]))
            if entity is not None and table.along[UID][row] == table.uid[row]:
                yield from ((int(table.uid[row]), thing) for thing in entity.plain())

    def met(self, table: Table) -> Iterator[tuple[int, int, Entity]]:
        """Yield (row, number, entity) for a table's living entities that have been accessed."""
        number = table.along[NUMBER]
        for row in np.flatnonzero(table.alive & (table.along[UID] == table.uid)).tolist():
            if (entity := self.held(int(number[row]))) is not None:
                yield row, int(number[row]), entity

    def empty(self, table: Table) -> None:
        """Discard all entities of a table, and the data that only esper stores for them."""
        for number in table.along[NUMBER][table.along[UID] != 0].tolist():
            self._drop(number)
        table.along[UID][:] = 0
        self.stale = True

    def _changed(self) -> None:
        self.places.clear()
        for cache in self.caches:
            cache.clear()

    def _make(self, number: int, table: Table, row: int) -> Entity:
        entity = Entity(self, number, table.name)
        entity.row, entity.uid = row, int(table.uid[row])
        dict.__setitem__(self.entities, number, entity)
        return entity

    def _settle(self, table: Table) -> None:
        """Point the existing handles at the current rows and columns."""
        rows = table.rows()
        for number, row in zip(table.along[NUMBER][rows].tolist(), rows.tolist(), strict=True):
            if (entity := self.held(number)) is not None:
                entity.settle(row, int(table.uid[row]))

    def _drop(self, number: int) -> None:
        if (entity := dict.pop(self.entities, number, None)) is not None:
            for kind in dict.keys(entity):
                self.strike(kind, number)

    # --- access ---------------------------------------------------------------------------------------------

    def made(self, number: int) -> Entity | None:
        """Create and return the entity with a number, or return None if no entity has it."""
        place = self.find(number)
        return None if place is None else self._make(number, *place)

    def find(self, number: object) -> tuple[Table, int] | None:
        """Return the table and row of the entity with a number, or None if no entity has it."""
        if self.looked_at is not None and self.looked_at[0] == number:
            return self._if_there(*self.looked_at)
        if not isinstance(number, int):
            return None
        for table in self._tables():
            if table.name not in self.places:
                rows = table.rows()
                order = np.argsort(table.along[NUMBER][rows])
                self.places[table.name] = table.along[NUMBER][rows][order], rows[order]
            numbers, rows = self.places[table.name]
            at = int(np.searchsorted(numbers, number))
            if at < numbers.size and numbers[at] == number:
                return self._if_there(number, table, int(rows[at]))
        return None

    def _if_there(self, number: int, table: Table, row: int) -> tuple[Table, int] | None:
        there = table.along[NUMBER][row] == number and table.along[UID][row] == table.uid[row]
        return (table, row) if there else None

    def numbers_with(self, kind: type) -> Iterator[int]:
        """Yield the numbers of all entities that have a column component, and prepare each for fast access."""
        try:
            with uncollected():  # otherwise thousands of new handles would be scanned repeatedly
                for table in self._tables():
                    if kind in table.columns or kind in table.derived:
                        rows = table.rows()
                        for number, row in zip(
                            table.along[NUMBER][rows].tolist(), rows.tolist(), strict=True
                        ):
                            self.looked_at = number, table, row
                            yield number
                yield from [one.number for one in self.waiting.values() if kind in one]
        finally:
            self.looked_at = None

    def count_with(self, kind: type) -> int:
        """Return how many entities have a column component."""
        return sum(
            table.n for table in self._tables() if kind in table.columns or kind in table.derived
        ) + sum(kind in one for one in self.waiting.values())

    def all_numbers(self) -> tuple[int, ...]:
        """Return the numbers of all entities."""
        living = [table.along[NUMBER][table.rows()].tolist() for table in self._tables()]
        return *itertools.chain(*living), *(one.number for one in self.waiting.values())

    def kinds_of(self, entity: Entity) -> list[Any]:
        """Return an entity's column components."""
        table = self._table_of(entity)
        return [] if table is None else [*table.columns, *table.derived]

    def is_in_table(self, entity: Entity, kind: type) -> bool:
        """Return whether a component is a column of an entity's table."""
        table = self._table_of(entity)
        return table is not None and (kind in table.columns or kind in table.derived)

    def handle(self, entity: Entity, kind: type) -> Any:
        """Return a handle to an entity's row, or None if its table lacks these columns."""
        table = self._table_of(entity)
        if table is None or not (kind in table.columns or kind in table.derived):
            return None
        return self.world()._handle(table, entity.row, kind)

    def _table_of(self, entity: Entity) -> Table | None:
        world = self.world()
        return None if world is None or entity.row == WAITING else world.tables[entity.table]

    def _tables(self) -> Iterable[Table]:
        world = self.world()
        return () if world is None else world.tables.values()

    # --- births and deaths ----------------------------------------------------------------------------------

    def create(self, number: int, things: dict[Any, Any]) -> None:
        """Request a newborn with these components; it is born at once or, within a tick, at the end of
        `reproduce`."""
        world = self.world()
        require_whole(world, "esper.create_entity", within=True)
        handles = [thing for thing in things.values() if isinstance(thing, Handle)]
        table = self._table_for([type(handle) for handle in handles], list(things))
        world.spawn(table.name, *handles)
        entity = Entity(self, number, table.name, things)
        entity.request = table.births[-1]
        self.waiting[id(entity.request)] = entity
        dict.__setitem__(self.entities, number, entity)
        if not world.ticking:
            with whole(world, f"the birth of esper's entity {number}"):
                world._flush_births()

    def _table_for(self, kinds: list[Any], named: list[Any]) -> Table:
        """Return the only table with exactly these components or, failing that, the only one with all of
        them. Raises a TypeError that names the tables."""
        world = self.world()
        fitting = [t for t in world.tables.values() if kinds and t.has(kinds)]
        alike = [t for t in fitting if len(t.columns) == len(kinds)]
        if len(alike) == 1 or len(fitting) == 1:
            return (alike if len(alike) == 1 else fitting)[0]
        asked = f"esper.create_entity({', '.join(name_of(k) for k in named)})"
        if fitting:
            names = [t.name for t in fitting]
            raise TypeError(
                f"{asked}: {listed(names)} of {self.called} have these components; "
                f"name one of them, as in world.spawn({names[0]!r}, …)"
            )
        tables = "; ".join(
            f"{t.name} ({listed(name_of(c) for c in (*t.columns, *t.derived))})"
            for t in world.tables.values()
        )
        raise TypeError(
            f"{asked}: no table of {self.called} has all of them; "
            f"its tables are {tables or 'none'}. An entity is a row of a table; to add a table: "
            "world.add_table(name, Component, …)"
        )

    def newborn(self, request: object) -> tuple[Handle, ...] | None:
        """Return the values given to the entity of a birth request, or None if no entity is waiting for that
        birth."""
        entity = self.waiting.get(id(request))
        return (
            None if entity is None else tuple(thing for thing in entity.values() if isinstance(thing, Handle))
        )

    def bear(self, request: object, table: Table, row: int) -> None:
        """Assign a row to the entity that was waiting for this birth."""
        if (entity := self.waiting.pop(id(request), None)) is not None:
            self._drop(int(table.along[NUMBER][row]))
            entity.request = None
            table.along[NUMBER][row], table.along[UID][row] = entity.number, table.uid[row]
            entity.settle(row, int(table.uid[row]))
            self._changed()

    def delete(self, number: int, immediate: bool = False) -> None:
        """Kill an entity at the end of the `die` phase or, if `immediate` between ticks, at once. Raises
        KeyError if it is not alive."""
        world, entity = self.world(), self.entities[number]
        if entity.row == WAITING:
            births = world.tables[entity.table].births
            births[:] = [request for request in births if request is not entity.request]
            del self.waiting[id(entity.request)]
            self._drop(number)
            self._changed()
            return
        if immediate and world.ticking:
            self.refuse(
                "delete_entity",
                "immediate=True: within a tick deaths take effect at the end of the `die` phase; omit `immediate`",
            )
        world.kill(entity.uid, "deleted")
        if immediate:
            with whole(world, f"the death of esper's entity {number}"):
                world.turnover.bury(world.tables[entity.table], np.array([entity.row]))

    def doomed(self, number: object) -> bool:
        """Return whether an entity has a cause of death."""
        place = self.find(number)
        return place is not None and bool(place[0].cause[place[1]])


class Numbers:
    """The numbers of future entities, in place of esper's counter."""

    def __init__(self) -> None:
        self.next = 1

    def __next__(self) -> int:
        self.next += 1
        return self.next - 1

    def take(self, n: int) -> np.ndarray:
        """Return the next `n` numbers: i64[n]."""
        self.next += n
        return np.arange(self.next - n, self.next)
