"""Handles in debug mode: they refuse to read or write a row that is no longer their owner's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ecs_eco.debug.errors import StaleHandle
from ecs_eco.engine.schema import Columns

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


class Guard(Columns):
    """One organism's columns, as its handle sees them in debug mode:
    every access checks that the row is still its own."""

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
            fate = (
                f"uid {uid} is dead, and {now}; keep uids and ask world.get again"
                if not (table.uid == uid).any()
                else (f"uid {uid} is no longer in row {row}: rows were reordered; ask world.get again")
            )
            raise StaleHandle(
                f"tables[{table.name!r}]: {self._component.__name__}.{name} through a handle "
                f"kept too long: {fate}"
            )
        return getattr(table[self._component], name)

    @property
    def __dict__(self) -> dict[str, Any]:  # type: ignore[override]
        return {name: getattr(self, name) for name in self._component.fields}
