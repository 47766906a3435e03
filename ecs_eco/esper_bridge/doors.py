"""Where esper's functions reach a world: dicts, sets and a list that act
on its tables when they are read or written.

esper keeps the state of a context in such objects, which `switch_world` exchanges, and its functions do
nothing but call them. So these reach every caller, also one that imported esper's functions before this
package, and other contexts of esper know nothing of them. Each says which function of esper comes to it; what
is to be done is in `registry`.
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
_item = dict.__getitem__  # asked for each entity of a loop: `super()` would take as long again


class Components(dict[type, Any]):
    """Which entities have a component: a set of numbers for each type of plain objects."""

    __slots__ = ("registry",)
    registry: Any

    def get(self, kind: type, default: object = None) -> Any:
        """Return the set of a type, as things stand now."""
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
        """What `esper.clear_database` comes to first: a refusal."""
        esper._entity_count = self.registry.numbers  # it has put another one there
        self.registry.refuse(
            "clear_database",
            "would take all organisms out of it; esper.delete_entity, or world.kill(uid), "
            "lets one die; an empty world is another World",
        )


class Entities(dict[int, Any]):
    """All entities by their numbers; one is made when it is looked at."""

    __slots__ = ("registry",)
    registry: Any

    def __getitem__(self, number: int) -> Any:
        if self.registry.stale:
            self.registry.refresh()
        return _item(self, number)

    def __missing__(self, number: int) -> Entity:
        if (entity := self.registry.made(number)) is not None:
            return entity
        for kind in tuple(self.registry.components):  # esper.add_component has put it there first
            self.registry.strike(kind, number)
        raise KeyError(f"{self.registry.called} has no entity {number}: it has died, or never lived")

    def __contains__(self, number: object) -> bool:
        self.registry.refresh()
        return super().__contains__(number) or self.registry.find(number) is not None

    def __iter__(self) -> Iterator[int]:
        self.registry.refresh()
        return iter(self.registry.all_numbers())

    def get(self, number: int, default: object = None) -> Any:
        """Return the components of an entity, as things stand now."""
        return self[number] if number in self else default

    def __setitem__(self, number: int, things: dict[type, object]) -> None:
        """What `esper.create_entity` does with it: a spawn."""
        try:
            self.registry.create(number, things)
        except BaseException:
            if not super().__contains__(number):
                for kind in things:
                    self.registry.strike(kind, number)
            raise

    def __delitem__(self, number: int) -> None:
        """What `esper.delete_entity(number, immediate=True)` does, after it has taken it off all sets."""
        for kind in dict.keys(super().__getitem__(number)):
            if not is_column(kind):
                self.registry.components.setdefault(kind, set()).add(number)
        self.registry.delete(number, immediate=True)


class Dead(set[int]):
    """The entities that are to die: those that the tables give a cause of death. It holds nothing itself."""

    __slots__ = ("registry",)
    registry: Any

    def add(self, number: int) -> None:
        """What `esper.delete_entity` does with it."""
        self.registry.delete(number)

    def __contains__(self, number: object) -> bool:
        return self.registry.doomed(number)

    def __bool__(self) -> bool:
        """What `esper.process` and `esper.clear_dead_entities` ask first:
        whether there is something to clear."""
        world = self.registry.world()
        if world is not None and world.ticking:
            self.registry.refuse(
                "clear_dead_entities",
                "deaths take effect at the end of the phase `die`; between ticks it works",
            )
        return world is not None and any(t.doomed().size for t in world.tables.values())

    def __iter__(self) -> Iterator[int]:
        return iter(())

    def clear(self) -> None:
        """What `esper.clear_dead_entities` does with it at its end:
        those with a cause of death leave their rows."""
        world = self.registry.world()
        with whole(world, f"the deaths before tick {world.tick}"):
            world._flush_deaths()


class Cache(dict[type | tuple[type, ...], Any]):
    """What esper has found before: forgotten when somebody was born or died."""

    __slots__ = ("registry",)
    registry: Any

    def get(self, kinds: type | tuple[type, ...], default: object = None) -> Any:
        """Return what was found for these types, if it still holds."""
        self.registry.refresh()
        return super().get(kinds, default)


class Processors(list[esper.Processor]):
    """What esper runs: a processor that makes a tick pass. Those of the tick are in the schedule of the world."""

    __slots__ = ("registry",)
    registry: Any

    def append(self, processor: esper.Processor) -> None:
        """What `esper.add_processor` does: add a system by its phase, or by its priority where that is not 0."""
        self.registry.world().add_system(processor, priority=processor.priority or None)

    def remove(self, processor: esper.Processor) -> None:
        """What `esper.remove_processor` does last: it has left the schedule by then."""

    def __iter__(self) -> Iterator[esper.Processor]:
        registry = self.registry
        if registry.world().ticking:
            registry.refuse("process", "a tick is under way; one tick cannot pass within another")
        return iter((Tick(registry.world()),))


class Kinds(dict[type, Any]):
    """The processors of a world's schedule by their types."""

    __slots__ = ("registry",)
    registry: Any

    def get(self, kind: type, default: object = None) -> Any:
        """Return the last processor of a type, what `esper.get_processor` asks for."""
        return next((p for p in reversed(self.registry.world().schedule) if type(p) is kind), default)

    def __setitem__(self, kind: type, processor: esper.Processor) -> None:
        """What `esper.add_processor` does last: the schedule has it by then."""

    def pop(self, kind: type, *default: Any) -> Any:
        """What `esper.remove_processor` does: a plain processor goes, a system of the world's schedule stays."""
        if (processor := self.get(kind)) is not None:
            self.registry.world().remove_processor(processor)
        return processor


class Events(dict[str, Any]):
    """The handlers of each event."""

    __slots__ = ("registry",)
    registry: Any

    def __setitem__(self, name: str, handlers: object) -> None:
        """What `esper.set_handler` does with the first of an event: it hands in a set, and gets ours."""
        super().__setitem__(name, Handlers(self, name))


class Handlers:
    """The handlers of one event by weak references, called in the order in which they were set.

    A handler that nobody holds any longer leaves it whatever world esper shows then, and methods may be
    removed: esper's own sets know neither.
    """

    def __init__(self, events: Events, name: str) -> None:
        self.events, self.name = events, name
        self.references: dict[Reference, None] = {}

    def add(self, reference: Reference) -> None:
        """Take a handler, by a reference of our own."""
        self.references[self._of(reference, self._leave)] = None

    def remove(self, reference: Reference) -> None:
        """Let a handler go."""
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
    """What `esper.process` finds instead of processors between ticks: a whole tick of the world."""

    def __init__(self, world: LivingWorld) -> None:
        self.world = world

    def process(self, *arguments: object, **named: object) -> None:
        """Let one tick pass."""
        if arguments or named:
            raise TypeError(
                f"esper.process: systems of the world {self.world.name!r} take no arguments; "
                "world.dt is the length of a tick"
            )
        self.world.run(1)
