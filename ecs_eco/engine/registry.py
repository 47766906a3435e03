"""The entities of one world as esper knows them: made when somebody looks,
brought up to date when somebody looks again."""

from __future__ import annotations

import gc
import itertools
import weakref
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from ecs_eco.engine.doors import (
    WAITING,
    Cache,
    Components,
    Dead,
    Entities,
    Entity,
    Events,
    Kinds,
    Processors,
    is_column,
    name_of,
)
from ecs_eco.engine.errors import listed
from ecs_eco.engine.interruption import require_whole, whole
from ecs_eco.engine.schema import Handle

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


class Registry:
    """All that esper holds of one world, which it knows weakly."""

    def __init__(self, world: Any) -> None:
        self.world: Any = weakref.ref(world)
        self.numbers = itertools.count(1)
        self.components, self.entities, self.dead = Components(), Entities(), Dead()
        self.caches = Cache(), Cache()
        self.processors, self.kinds = Processors(), Kinds()
        self.events = Events()
        # whether somebody was born, died or moved to another row since esper was brought up to date
        self.stale = False
        self.due = False  # whether the next to go through the processors is a tick of the world
        self.waiting: dict[int, Entity] = {}  # not born yet, by the identity of what was asked of the table
        parts: tuple[Any, ...] = (self.components, self.entities, self.dead, *self.caches, self.processors,
                                  self.kinds, self.events)
        for part in parts:
            part.registry = self

    @property
    def state(self) -> tuple[Any, ...]:
        """The state of a context, as `esper.switch_world` keeps it."""
        return (self.numbers, self.components, self.entities, self.dead, *self.caches, self.processors,
                self.kinds, False, {}, self.events)

    @property
    def called(self) -> str:
        """The world by its name, for messages."""
        world = self.world()
        return "a world that is gone" if world is None else f"world {world.name!r}"

    def refuse(self, function: str, why: str) -> NoReturn:
        """Raise what a function of esper cannot do here."""
        raise RuntimeError(f"esper.{function}, {self.called}: {why}")

    # --- who is in it ---------------------------------------------------------------------------------------

    def enlist(self, kind: Any, number: int) -> None:
        """Put an entity on the list of those that have a component."""
        self.components.setdefault(kind, set()).add(number)

    def strike(self, kind: Any, number: int) -> None:
        """Take an entity off the list of those that have a component."""
        if (numbers := dict.get(self.components, kind)) is not None:
            numbers.discard(number)
            if not numbers:
                del self.components[kind]

    def refresh(self) -> None:
        """Bring esper up to date where the tables say that it is not."""
        if self.stale and (world := self.world()) is not None:
            world.sync()

    def sync(self, tables: Iterable[Table]) -> None:
        """Bring esper's entities up to date: one for each living organism, with a handle for each component.
        """
        self.stale = False
        changed = [t for t in tables if (t.entity_uid != t.uid).any()]
        if not changed:
            return
        collecting = gc.isenabled()
        gc.disable()  # a collection while 100,000 handles are made would look at all of them, again and again
        for table in changed:
            rows = np.flatnonzero(table.entity_uid != table.uid)
            for row in rows.tolist():
                self._leave(table, row)
            for row in rows[table.uid[rows] != 0].tolist():
                self._enter(table, row)
        if collecting:
            gc.enable()
        self._changed()

    def number(self, table: Table, row: int) -> int:
        """Return the number of the living entity of a row, which it gets where it has none yet."""
        if table.entity_uid[row] != table.uid[row]:
            self._leave(table, row)
            self._enter(table, row)
            self._changed()
        return int(table.entity[row])

    def held(self, number: int) -> Entity | None:
        """Return what esper holds of a number, which is not brought up to date."""
        return dict.get(self.entities, number)

    def of(self, table: Table, row: int) -> dict[Any, Any]:
        """Return what esper holds of a living row's owner, which has nothing to itself
        where nobody has looked."""
        entity = self.held(int(table.entity[row]))
        return (entity if entity is not None and entity.uid == table.uid[row]
                and entity.table == table.name else {})

    def empty(self, table: Table) -> None:
        """Forget all entities of a table, and what esper alone knows of them."""
        for number in table.entity[table.entity_uid != 0].tolist():
            self._drop(number)
        table.entity_uid[:] = 0
        self.stale = True

    def _changed(self) -> None:
        for cache in self.caches:
            cache.clear()

    def _leave(self, table: Table, row: int) -> None:
        """Drop the entity of a row where its owner no longer lives there."""
        if (number := int(table.entity[row])) and not (table.uid[row] and self.of(table, row)):
            self._drop(number)
        if not table.uid[row]:
            table.entity_uid[row] = 0

    def _enter(self, table: Table, row: int) -> None:
        """Give the owner of a row its entity: the one that it has, with handles of this row, or a new one."""
        entity = self.held(int(table.entity[row])) if self.of(table, row) else None
        if entity is None:
            entity = Entity(self, next(self.numbers), table.name)
            dict.__setitem__(self.entities, entity.number, entity)
        self._settle(entity, table, row)

    def _settle(self, entity: Entity, table: Table, row: int) -> None:
        """Let the handles of an entity, which stay the objects that they are, mean a row of a table."""
        world = self.world()
        entity.row, entity.uid = row, int(table.uid[row])
        table.entity[row], table.entity_uid[row] = entity.number, entity.uid
        for kind in [kind for kind in entity if is_column(kind) and kind not in table]:
            dict.pop(entity, kind)
            self.strike(kind, entity.number)
        for kind in (*table.columns, *table.derived):
            handle = world._handle(table, row, kind)
            if kind in entity:
                entity[kind]._columns, entity[kind]._row = handle._columns, row
            else:
                dict.__setitem__(entity, kind, handle)
                self.enlist(kind, entity.number)

    def _drop(self, number: int) -> None:
        for kind in dict.pop(self.entities, number, {}):
            self.strike(kind, number)

    # --- who comes and goes ---------------------------------------------------------------------------------

    def create(self, number: int, things: dict[Any, Any]) -> None:
        """Ask for a newborn with these components; it lives at once,
        or within a tick from the end of `reproduce` on."""
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
                world.flush_births()

    def _table_for(self, kinds: list[Any], named: list[Any]) -> Table:
        """Return the one table whose components are these, or that alone has them all;
        TypeError names the tables."""
        world = self.world()
        fitting = [t for t in world.tables.values() if kinds and t.has(kinds)]
        alike = [t for t in fitting if len(t.columns) == len(kinds)]
        if len(alike) == 1 or len(fitting) == 1:
            return (alike if len(alike) == 1 else fitting)[0]
        asked = f"esper.create_entity({', '.join(name_of(k) for k in named)})"
        if fitting:
            names = [t.name for t in fitting]
            raise TypeError(f"{asked}: {listed(names)} of {self.called} have these components; "
                            f"world.spawn({names[0]!r}, …), say, tells which")
        tables = "; ".join(f"{t.name} ({listed(name_of(c) for c in (*t.columns, *t.derived))})"
                           for t in world.tables.values())
        raise TypeError(f"{asked}: no table of {self.called} has them all; "
                        f"its tables are {tables or 'none'}. An entity is a row of a table: "
                        "world.add_table(name, Component, …) declares another")

    def newborn(self, request: Any) -> tuple[Handle, ...] | None:
        """Return what an entity that waits for its birth has been given, as it is now;
        None where no entity waits for this one."""
        entity = self.waiting.get(id(request))
        return None if entity is None else tuple(thing
                                                 for thing in entity.values() if isinstance(thing, Handle))

    def bear(self, request: Any, table: Table, row: int) -> None:
        """Let the entity that has waited for this birth be that of a row."""
        if (entity := self.waiting.pop(id(request), None)) is not None:
            self._leave(table, row)
            entity.request = None
            self._settle(entity, table, row)
            self._changed()

    def delete(self, number: int, immediate: bool = False) -> None:
        """Let an entity die: at the end of the phase `die`, or at once, between ticks;
        KeyError where it does not live."""
        world, entity = self.world(), self.entities[number]
        if entity.row == WAITING:
            births = world.tables[entity.table].births
            births[:] = [request for request in births if request is not entity.request]
            del self.waiting[id(entity.request)]
            self._drop(number)
            self._changed()
            return
        if immediate and world.ticking:
            self.refuse("delete_entity",
                        "immediate=True: within a tick deaths take effect at the end of the phase `die`; "
                        "leave `immediate` away")
        world.kill(entity.uid, "deleted")
        if immediate:
            with whole(world, f"the death of esper's entity {number}"):
                world.bury(world.tables[entity.table], np.array([entity.row]))

    def doomed(self, number: object) -> bool:
        """Return whether an entity has a cause of death."""
        entity, world = dict.get(self.entities, number), self.world()
        return (entity is not None and entity.row != WAITING
                and bool(world.tables[entity.table].cause[entity.row]))
