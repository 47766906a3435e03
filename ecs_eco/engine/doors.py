"""Where esper's functions reach a world: dicts, sets and a list that act
on its tables when they are read or written.

esper keeps the state of a context in such objects, which `switch_world` exchanges, and its functions do
nothing but call them. So these reach every caller, also one that imported esper's functions before this
package, and other contexts of esper know nothing of them. Each says which function of esper comes to it; what
is to be done is in `registry`.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from types import MethodType
from typing import Any, NoReturn

import esper

from ecs_eco.engine.interruption import whole
from ecs_eco.engine.schema import Handle

WAITING = -1  # the row of an entity that is not born yet
_item = dict.__getitem__  # asked for each entity of a loop: `super()` would take as long again


class Entity(dict[Any, Any]):
    """The components of one entity by their types; whose handles they are: table, row, uid."""

    __slots__ = ("number", "registry", "request", "row", "table", "uid")

    def __init__(self, registry: Any, number: int, table: str, things: Any = ()) -> None:
        super().__init__(things)
        self.registry, self.number, self.table = registry, number, table
        self.row, self.uid = WAITING, 0
        self.request: Any = None  # what was asked of the table, while it is not born yet

    def __setitem__(self, kind: Any, thing: Any) -> None:
        """What `esper.add_component` does with it: a plain object is taken, a column refused."""
        if not (is_column(kind) or isinstance(thing, Handle)):
            super().__setitem__(kind, thing)
            return
        if kind not in self:
            self.registry.strike(kind, self.number)
        name, own = name_of(kind), kind in self
        how = (f"its {name} is there: write into its fields, as in esper.component_for_entity({self.number}, "
               f"{name}).{_first(kind)} = …")
        if not own:
            how = f"a component belongs to all of a table: world.table({self.table!r}).add_component({name})"
        raise TypeError(f"esper.add_component: entity {self.number} is one of the table {self.table!r}, "
                        f"and {how}")

    def pop(self, kind: Any, *default: Any) -> Any:
        """What `esper.remove_component` does with it: a plain object goes, a column stays."""
        if kind not in self or not is_column(kind):
            return super().pop(kind, *default)
        self.registry.enlist(kind, self.number)
        raise TypeError(f"esper.remove_component: entity {self.number} is one of the table {self.table!r}, "
                        f"all of which have {name_of(kind)}; "
                        "give what it says another value, or keep those without it in a table of their own: "
                        "world.add_table(…)")


class Components(dict[Any, Any]):
    """Which entities have a component: a set of numbers for each type."""

    __slots__ = ("registry",)
    registry: Any

    def get(self, kind: Any, default: Any = None) -> Any:
        """Return the set of a type, as things stand now."""
        self.registry.refresh()
        return super().get(kind, default)

    def clear(self) -> None:
        """What `esper.clear_database` comes to first: a refusal."""
        esper._entity_count = self.registry.numbers  # it has put another one there
        self.registry.refuse("clear_database",
                             "would take all organisms out of it; esper.delete_entity, or world.kill(uid), "
                             "lets one die; an empty world is another World")


class Entities(dict[Any, Any]):
    """All entities by their numbers."""

    __slots__ = ("registry",)
    registry: Any

    def __getitem__(self, number: Any) -> Any:
        if self.registry.stale:
            self.registry.refresh()
        return _item(self, number)

    def __missing__(self, number: Any) -> NoReturn:
        for kind in tuple(self.registry.components):  # esper.add_component has put it there first
            self.registry.strike(kind, number)
        raise KeyError(f"{self.registry.called} has no entity {number}: it has died, or never lived")

    def __contains__(self, number: object) -> bool:
        self.registry.refresh()
        return super().__contains__(number)

    def __iter__(self) -> Iterator[Any]:
        self.registry.refresh()
        return iter(tuple(super().__iter__()))

    def get(self, number: Any, default: Any = None) -> Any:
        """Return the components of an entity, as things stand now."""
        self.registry.refresh()
        return super().get(number, default)

    def __setitem__(self, number: Any, things: Any) -> None:
        """What `esper.create_entity` does with it: a spawn."""
        try:
            self.registry.create(number, things)
        except BaseException:
            if not super().__contains__(number):
                for kind in things:
                    self.registry.strike(kind, number)
            raise

    def __delitem__(self, number: Any) -> None:
        """What `esper.delete_entity(number, immediate=True)` does with it,
        after it has taken it off all sets."""
        for kind in super().__getitem__(number):
            self.registry.enlist(kind, number)
        self.registry.delete(number, immediate=True)


class Dead(set[Any]):
    """The entities that are to die: those that the tables give a cause of death. It holds nothing itself."""

    __slots__ = ("registry",)
    registry: Any

    def add(self, number: Any) -> None:
        """What `esper.delete_entity` does with it."""
        self.registry.delete(number)

    def __contains__(self, number: object) -> bool:
        return self.registry.doomed(number)

    def __bool__(self) -> bool:
        """What `esper.process` and `esper.clear_dead_entities` ask first:
        whether there is something to clear."""
        if self.registry.due:
            return False  # a tick begins, and has its own place for deaths
        world = self.registry.world()
        if world is not None and world.ticking:
            self.registry.refuse("clear_dead_entities",
                                 "deaths take effect at the end of the phase `die`; between ticks it works")
        return world is not None and any(t.doomed().size for t in world.tables.values())

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def clear(self) -> None:
        """What `esper.clear_dead_entities` does with it at its end:
        those with a cause of death leave their rows."""
        world = self.registry.world()
        with whole(world, f"the deaths before tick {world.tick}"):
            world.flush_deaths()


class Cache(dict[Any, Any]):
    """What esper has found before: forgotten when somebody was born or died."""

    __slots__ = ("registry",)
    registry: Any

    def get(self, kinds: Any, default: Any = None) -> Any:
        """Return what was found for these types, if it still holds."""
        self.registry.refresh()
        return super().get(kinds, default)


class Processors(list[Any]):
    """The processors of a tick in their order; between ticks one that makes a tick pass."""

    __slots__ = ("registry",)
    registry: Any

    def append(self, processor: Any) -> None:
        """What `esper.add_processor` does with it: a system of the world, by its phase,
        or by its priority where that is not 0."""
        self.registry.world().add_system(processor, priority=processor.priority or None)

    def __iter__(self) -> Iterator[Any]:
        registry = self.registry
        if registry.due:
            registry.due = False
            return iter(tuple(super().__iter__()))
        if registry.world().ticking:
            registry.refuse("process", "a tick is under way; one tick cannot pass within another")
        return iter((Tick(registry.world()),))


class Kinds(dict[Any, Any]):
    """The processors by their types."""

    __slots__ = ("registry",)
    registry: Any

    def pop(self, kind: Any, *default: Any) -> Any:
        """What `esper.remove_processor` does with it: a plain processor goes,
        a system of the world's schedule stays."""
        if kind in self:
            self.registry.world().remove_processor(self[kind])
        return super().pop(kind, *default)


class Events(dict[str, Any]):
    """The handlers of each event."""

    __slots__ = ("registry",)
    registry: Any

    def __setitem__(self, name: str, handlers: Any) -> None:
        """What `esper.set_handler` does with the first of an event: it hands in a set, and gets ours."""
        super().__setitem__(name, Handlers(self, name))


class Handlers:
    """The handlers of one event by weak references, called in the order in which they were set.

    A handler that nobody holds any longer leaves it whatever world esper shows then, and methods may be
    removed: esper's own sets know neither.
    """

    def __init__(self, events: Events, name: str) -> None:
        self.events, self.name = events, name
        self.references: dict[Any, None] = {}

    def add(self, reference: Any) -> None:
        """Take a handler, by a reference of our own."""
        self.references[self._of(reference, self._leave)] = None

    def remove(self, reference: Any) -> None:
        """Let a handler go."""
        del self.references[self._of(reference)]

    def __contains__(self, reference: Any) -> bool:
        return self._of(reference) in self.references

    def __iter__(self) -> Iterator[Any]:
        return iter(tuple(self.references))

    def __len__(self) -> int:
        return len(self.references)

    def _leave(self, reference: Any) -> None:
        self.references.pop(reference, None)
        if not self.references and self.events.get(self.name) is self:
            del self.events[self.name]

    @staticmethod
    def _of(reference: Any, leave: Any = None) -> Any:
        function = reference()
        return (weakref.WeakMethod if isinstance(function, MethodType) else weakref.ref)(function, leave)


class Tick(esper.Processor):
    """What `esper.process` finds instead of processors between ticks: a whole tick of the world."""

    def __init__(self, world: Any) -> None:
        self.world = world

    def process(self, *arguments: Any, **named: Any) -> None:
        """Let one tick pass."""
        if arguments or named:
            raise TypeError(f"esper.process: systems of the world {self.world.name!r} take no arguments; "
                            "world.dt is the length of a tick")
        self.world.run(1)


def is_column(kind: Any) -> bool:
    """Return whether a type is a component that tables keep as columns."""
    return isinstance(kind, type) and issubclass(kind, Handle)


def name_of(kind: Any) -> str:
    """Return the name of a type, for messages."""
    return getattr(kind, "__name__", repr(kind))


def _first(kind: Any) -> str:
    return next(iter(getattr(kind, "fields", ())), "field")
