"""Conformance check for a component."""

import numpy as np

from ecs_eco.engine.schema import Handle
from ecs_eco.engine.table import Table


def check_component(kind: object) -> None:
    """Check a component's declaration and docstring, and that its columns keep the values written to them.

    Parameters
    ----------
    kind : type

    Raises
    ------
    AssertionError
        If a check fails.

    Examples
    --------
    >>> from ecs_eco.components import Metabolism
    >>> from ecs_eco.testing import check_component
    >>> check_component(Metabolism)
    """
    if not (isinstance(kind, type) and issubclass(kind, Handle) and kind.fields):
        raise AssertionError(f"{kind!r} is not a component; declare it with @component")
    if not (kind.__doc__ or "").strip():
        raise AssertionError(f"{kind.__name__}: describe it in a docstring")
    words = {d: 3 for type_, _ in kind.fields.values() for d in type_.shape if isinstance(d, str)}
    table = Table("test", (kind,), capacity=1, dims=words)
    table.occupy(3, 1, 0, {})
    for name, (type_, default) in kind.fields.items():
        where, column = f"{kind.__name__}.{name}", table.field(kind, name)
        if np.issubdtype(type_.dtype, np.floating) and not np.isfinite(column).all():
            raise AssertionError(
                f"{where}: the default {default!r} is not finite; newborns need a valid value"
            )
        if not np.array_equal(column[:3], np.broadcast_to(default, column[:3].shape).astype(column.dtype)):
            raise AssertionError(f"{where}: newborns have {column[0]!r} instead of the default {default!r}")
        _check_writing(kind, name, table)
    if len(kind.__slots__) or hasattr(kind(), "__dict__"):
        raise AssertionError(f"{kind.__name__}: handles must be small and store only the fields")


def _check_writing(kind: type[Handle], name: str, table: Table) -> None:
    """Write the middle row through a handle, and check that only this row has changed."""
    column = table.field(kind, name)
    before = column.copy()
    value = np.logical_not(before[1]).astype(column.dtype)
    setattr(kind.attach(table[kind], 1), name, value)
    after = table.field(kind, name)
    if not np.array_equal(after[1], value) or not np.array_equal(after[[0, 2]], before[[0, 2]]):
        raise AssertionError(f"{kind.__name__}.{name}: a handle must write only its own row")
    table.reserve(2 * table.capacity)
    if not np.array_equal(getattr(kind.attach(table[kind], 1), name), after[1]):
        raise AssertionError(f"{kind.__name__}.{name}: the value is lost when the table grows")
