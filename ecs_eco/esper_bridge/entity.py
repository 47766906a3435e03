"""The objects that esper receives for an entity, or for all entities with a component; they are derived from
tables on access."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ecs_eco.engine.schema import Handle

WAITING = -1  # the row of an entity that has not been born yet


class Entity(dict[type, Any]):
    """The components of one entity by type: handles to its row, created on access."""

    __slots__ = ("number", "registry", "request", "row", "table", "uid")

    def __init__(self, registry: Any, number: int, table: str, things: dict[type, Any] | None = None) -> None:
        super().__init__(things or {})
        self.registry, self.number, self.table = registry, number, table
        self.row, self.uid = WAITING, 0
        self.request: Any = None  # its birth request, until it is born

    def __missing__(self, kind: type) -> Any:
        handle = self.registry.handle(self, kind)
        if handle is None:
            raise KeyError(kind)
        super().__setitem__(kind, handle)
        return handle

    def __contains__(self, kind: object) -> bool:
        return super().__contains__(kind) or self.registry.is_in_table(self, kind)

    def get(self, kind: type, default: object = None) -> Any:
        """Return the component with a type."""
        return self[kind] if kind in self else default

    def __iter__(self) -> Iterator[type]:
        return iter(self.all())

    def __len__(self) -> int:
        return len(self.all())

    def keys(self) -> Any:
        """Return the types of all components."""
        return self.all().keys()

    def values(self) -> Any:
        """Return all components, for `esper.components_for_entity`."""
        return self.all().values()

    def items(self) -> Any:
        """Return all components by type."""
        return self.all().items()

    def all(self) -> dict[type, Any]:
        """Return all components by type: columns in table order, then plain objects."""
        held = dict(super().items())
        return {kind: self[kind] for kind in self.registry.kinds_of(self)} | held

    def plain(self) -> list[Any]:
        """Return the components that are not columns."""
        return [thing for thing in super().values() if not isinstance(thing, Handle)]

    def settle(self, row: int, uid: int) -> None:
        """Point the existing handles at a row of the entity's table."""
        self.row, self.uid = row, uid
        for kind, handle in list(super().items()):
            if is_column(kind):
                if (new := self.registry.handle(self, kind)) is None:
                    super().pop(kind)
                else:
                    handle._columns, handle._row = new._columns, row

    def __setitem__(self, kind: type, thing: object) -> None:
        """Add a plain object, but reject a column, for `esper.add_component`."""
        if not (is_column(kind) or isinstance(thing, Handle)):
            super().__setitem__(kind, thing)
            return
        own = kind in self
        if not own:
            self.registry.strike(kind, self.number)
        name = name_of(kind)
        how = (
            f"its {name} already exists: set its fields, as in esper.component_for_entity({self.number}, "
            f"{name}).{_first(kind)} = …"
        )
        if not own:
            how = (
                "all entities of a table have the same components: "
                f"world.table({self.table!r}).add_component({name})"
            )
        raise TypeError(
            f"esper.add_component: entity {self.number} belongs to the table {self.table!r}, and {how}"
        )

    def pop(self, kind: type, *default: Any) -> Any:
        """Remove a plain object, but refuse to remove a column, for `esper.remove_component`."""
        if kind not in self or not is_column(kind):
            return super().pop(kind, *default)
        raise TypeError(
            f"esper.remove_component: entity {self.number} belongs to the table {self.table!r}, "
            f"whose entities all have {name_of(kind)}; change its values, or put entities without it in another "
            "table: world.add_table(…)"
        )


class Members:
    """The numbers of all entities that have a column component, according to the tables."""

    __slots__ = ("kind", "registry")

    def __init__(self, registry: Any, kind: type) -> None:
        self.registry, self.kind = registry, kind

    def __iter__(self) -> Iterator[int]:
        return self.registry.numbers_with(self.kind)

    def __len__(self) -> int:
        return self.registry.count_with(self.kind)

    def add(self, number: int) -> None:
        """Do nothing, for `esper.create_entity`: the table will list the entity."""

    def discard(self, number: int) -> None:
        """Do nothing, for `esper.delete_entity` and `esper.remove_component`: the table lists the entity."""


def is_column(kind: object) -> bool:
    """Return whether a type is a component that tables store as columns."""
    return isinstance(kind, type) and issubclass(kind, Handle)


def name_of(kind: object) -> str:
    """Return the name of a type, for messages."""
    return getattr(kind, "__name__", repr(kind))


def _first(kind: object) -> str:
    return next(iter(getattr(kind, "fields", ())), "field")
