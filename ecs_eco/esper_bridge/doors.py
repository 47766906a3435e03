"""The dicts, sets and list through which esper's functions access a world: reading or writing them acts on
its tables.

esper stores the state of a context in such objects, which `switch_world` swaps, and its functions only call
their methods. These objects therefore work for every caller, including code that imported esper's functions
before this package, and do not affect esper's other contexts. Each docstring names the esper function that
calls the method; `registry` does the work.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterator
from types import MethodType
from typing import Any, TypeAlias

import esper

from ecs_eco.engine.interruption import whole
from ecs_eco.engine.living import LivingWorld
from ecs_eco.esper_bridge.entity import Entity, Members, is_column

Reference: TypeAlias = weakref.ref[Any]  # of a handler
_item = dict.__getitem__  # called for each entity in a loop: `super()` would double the time


class Components(dict[type, Any]):
    """The entities that have a component: a set of entity numbers for each type of plain object."""

    __slots__ = ("registry",)
    registry: Any

    def get(self, kind: type, default: object = None) -> Any:
        """Return the current set of entities with a component."""
        self.registry.refresh()
        return Members(self.registry, kind) if is_column(kind) else super().get(kind, default)

    def __contains__(self, kind: object) -> bool:
        return is_column(kind) or super().__contains__(kind)

    def __missing__(self, kind: type) -> Members:
        if not is_column(kind):
            raise KeyError(kind)
        return Members(self.registry, kind)

    def __delitem__(self, kind: type) -> None:
        if not is_column(kind):
            super().__delitem__(kind)

    def clear(self) -> None:
        """Reject `esper.clear_database`, which calls this first."""
        esper._entity_count = self.registry.numbers  # `esper.clear_database` has replaced it
        self.registry.refuse(
            "clear_database",
            "would remove all organisms; to remove one, use esper.delete_entity or world.kill(uid); for an empty "
            "world, create another World",
        )


class Entities(dict[int, Any]):
    """All entities by number; each entity object is created when it is accessed."""

    __slots__ = ("registry",)
    registry: Any

    def __getitem__(self, number: int) -> Any:
        if self.registry.stale:
            self.registry.refresh()
        return _item(self, number)

    def __missing__(self, number: int) -> Entity:
        if (entity := self.registry.made(number)) is not None:
            return entity
        for kind in tuple(self.registry.components):  # esper.add_component has already inserted it
            self.registry.strike(kind, number)
        raise KeyError(f"{self.registry.called} has no entity {number}: it has died or never existed")

    def __contains__(self, number: object) -> bool:
        self.registry.refresh()
        return super().__contains__(number) or self.registry.find(number) is not None

    def __iter__(self) -> Iterator[int]:
        self.registry.refresh()
        return iter(self.registry.all_numbers())

    def get(self, number: int, default: object = None) -> Any:
        """Return the current components of an entity."""
        return self[number] if number in self else default

    def __setitem__(self, number: int, things: dict[type, object]) -> None:
        """Spawn an entity, for `esper.create_entity`."""
        try:
            self.registry.create(number, things)
        except BaseException:
            if not super().__contains__(number):
                for kind in things:
                    self.registry.strike(kind, number)
            raise

    def __delitem__(self, number: int) -> None:
        """Delete an entity, for `esper.delete_entity(number, immediate=True)`, which has already removed it
        from all sets."""
        for kind in dict.keys(super().__getitem__(number)):
            if not is_column(kind):
                self.registry.components.setdefault(kind, set()).add(number)
        self.registry.delete(number, immediate=True)


class Dead(set[int]):
    """The entities marked to die, that is, those with a cause of death in their table; the set itself stores
    nothing."""

    __slots__ = ("registry",)
    registry: Any

    def add(self, number: int) -> None:
        """Mark an entity to die, for `esper.delete_entity`."""
        self.registry.delete(number)

    def __contains__(self, number: object) -> bool:
        return self.registry.doomed(number)

    def __bool__(self) -> bool:
        """Return whether any deaths are pending, for `esper.process` and `esper.clear_dead_entities`."""
        world = self.registry.world()
        if world is not None and world.ticking:
            self.registry.refuse(
                "clear_dead_entities",
                "deaths take effect at the end of the `die` phase; call it between ticks",
            )
        return world is not None and any(t.doomed().size for t in world.tables.values())

    def __iter__(self) -> Iterator[int]:
        return iter(())

    def clear(self) -> None:
        """Free the rows of entities with a cause of death, at the end of `esper.clear_dead_entities`."""
        world = self.registry.world()
        with whole(world, f"the deaths before tick {world.tick}"):
            world._flush_deaths()


class Cache(dict[type | tuple[type, ...], Any]):
    """esper's query cache, emptied after every birth or death."""

    __slots__ = ("registry",)
    registry: Any

    def get(self, kinds: type | tuple[type, ...], default: object = None) -> Any:
        """Return the cached result for these types if it is still valid."""
        self.registry.refresh()
        return super().get(kinds, default)


class Processors(list[esper.Processor]):
    """The processors that esper runs: only one, which runs a whole tick. All others are in the world's
    schedule."""

    __slots__ = ("registry",)
    registry: Any

    def append(self, processor: esper.Processor) -> None:
        """Add a system by its priority or, if that is 0, by its phase, for `esper.add_processor`."""
        self.registry.world().add_system(processor, priority=processor.priority or None)

    def remove(self, processor: esper.Processor) -> None:
        """Do nothing: `esper.remove_processor` has already removed the processor from the schedule."""

    def __iter__(self) -> Iterator[esper.Processor]:
        registry = self.registry
        if registry.world().ticking:
            registry.refuse("process", "a tick cannot run within another tick")
        return iter((Tick(registry.world()),))


class Kinds(dict[type, Any]):
    """The processors in a world's schedule by type."""

    __slots__ = ("registry",)
    registry: Any

    def get(self, kind: type, default: object = None) -> Any:
        """Return the last processor of a type, for `esper.get_processor`."""
        return next((p for p in reversed(self.registry.world().schedule) if type(p) is kind), default)

    def __setitem__(self, kind: type, processor: esper.Processor) -> None:
        """Do nothing: `esper.add_processor` has already added it to the schedule."""

    def pop(self, kind: type, *default: Any) -> Any:
        """Remove a plain processor, but refuse to remove a system, for `esper.remove_processor`."""
        if (processor := self.get(kind)) is not None:
            self.registry.world().remove_processor(processor)
        return processor


class Events(dict[str, Any]):
    """The handlers for each event."""

    __slots__ = ("registry",)
    registry: Any

    def __setitem__(self, name: str, handlers: object) -> None:
        """Store `Handlers` in place of esper's set, for the first `esper.set_handler` of an event."""
        super().__setitem__(name, Handlers(self, name))


class Handlers:
    """Weak references to the handlers for one event, called in the order they were set.

    A garbage-collected handler is removed no matter which world esper shows, and methods can be removed;
    esper's own sets support neither.
    """

    def __init__(self, events: Events, name: str) -> None:
        self.events, self.name = events, name
        self.references: dict[Reference, None] = {}

    def add(self, reference: Reference) -> None:
        """Add a handler through a new weak reference, which removes itself."""
        self.references[self._of(reference, self._leave)] = None

    def remove(self, reference: Reference) -> None:
        """Remove a handler."""
        del self.references[self._of(reference)]

    def __contains__(self, reference: Reference) -> bool:
        return self._of(reference) in self.references

    def __iter__(self) -> Iterator[Any]:
        return iter(tuple(self.references))

    def __len__(self) -> int:
        return len(self.references)

    def _leave(self, reference: Reference) -> None:
        self.references.pop(reference, None)
        if not self.references and self.events.get(self.name) is self:
            del self.events[self.name]

    @staticmethod
    def _of(reference: Reference, leave: Callable[[Reference], None] | None = None) -> Reference:
        function = reference()
        return (weakref.WeakMethod if isinstance(function, MethodType) else weakref.ref)(function, leave)


class Tick(esper.Processor):
    """The processor that `esper.process` runs between ticks, which runs a whole tick of the world."""

    def __init__(self, world: LivingWorld) -> None:
        self.world = world

    def process(self, *arguments: object, **named: object) -> None:
        """Run one tick."""
        if arguments or named:
            raise TypeError(
                f"esper.process: systems of the world {self.world.name!r} take no arguments; "
                "world.dt is the length of a tick"
            )
        self.world.run(1)
