"""Checks of values set outside a tick, which must be finite and within their limits.

Invalid values are wrapped or moved into range where possible; otherwise, an error names them. The checks
apply to everything that is not written by a system within a tick: spawned organisms, values written to
columns, handles, fields and ground between ticks, checkpoints and interventions. Positions beyond the edge of
a torus are wrapped, and so are headings; a position on a wall is moved just inside it. No values are checked
within a tick: kernels stay within their arrays whatever the values are, and debug mode reports the system
that wrote a bad value.
"""

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ecs_eco.engine.schema import Columns
from ecs_eco.space import scan
from ecs_eco.space.check_surroundings import check_surroundings
from ecs_eco.space.environment import Surroundings
from ecs_eco.space.geometry import back_into

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

# positions up to this many world lengths away are wrapped around a torus; float32 still resolves them
FURTHEST = 1000
TURN = np.float32(2 * np.pi)  # [rad] systems write values from 0 to this, inclusive


class Limits(NamedTuple):
    """The range of a component's field in one table: low to high, inclusive; `length` is the length of an
    axis of the space [m], or a full turn [rad]."""

    component: type[Any]
    field: str
    low: Any
    high: Any
    length: float = 0.0  # 0: neither a coordinate nor a heading
    around: bool = False  # whether it wraps around

    @property
    def name(self) -> str:
        """Component.field, as used in messages."""
        return f"{self.component.__name__}.{self.field}"

    @property
    def allowed(self) -> str:
        """The limits in words."""
        if self.length:
            unit, what = ("rad", "circle") if self.field == "heading" else ("m", "torus")
            back = (
                f"; values up to ±{FURTHEST * self.length:g} {unit} are wrapped around the {what}"
                if self.around
                else ""
            )
            return f"0 to {self.length:g} {unit}{back}"
        if self.high in (np.finfo(np.float32).max, np.finfo(np.float64).max):
            return "finite numbers"
        return f"{self.low:g} to {self.high:g}"

    def outside(self, values: np.ndarray) -> np.ndarray:
        """Return which values [k, …] are beyond the limits or not finite: bool[k]."""
        wrong = ~((values >= self.low) & (values <= self.high))
        return wrong.any(axis=tuple(range(1, wrong.ndim)))

    def brought_back(self, values: np.ndarray) -> np.ndarray:
        """Return positions f32[k] [m] or headings [rad], wrapped into the space or the circle if they are
        outside it and wrapping is possible."""
        if self.around:
            can = np.abs(values) <= FURTHEST * np.float32(self.length)
        else:
            can = values == np.float32(self.length)
        can &= self.outside(values)
        return np.where(can, back_into(np.where(can, values, 0), self.length, self.around), values).astype(
            np.float32
        )

    def refuse(self, label: str, values: np.ndarray) -> None:
        """Raise a ValueError if a value is outside; `label` names its owner, with {} for the row of the first
        such value."""
        rows = np.flatnonzero(self.outside(values))
        if rows.size:
            bad = np.atleast_1d(values[rows[0]])
            inside = np.atleast_1d((bad >= self.low) & (bad <= self.high)).ravel()
            value = bad.ravel()[np.flatnonzero(~inside)[0]]
            more = f" ({rows.size - 1} more)" if rows.size > 1 else ""
            raise ValueError(
                f"{label.format(int(rows[0]))}: {self.name} is {value}{more}; expected: {self.allowed}"
            )


class Looked(NamedTuple):
    """The fields that the gate checks in every table of a world."""

    key: list[Any]  # the values from which it was derived
    tables: tuple["Table", ...]
    columns: list[scan.ColumnGroup]  # by type
    limits: list[list[Limits | None]]  # limits of these columns; None: causes of death


def limits_of(world: Surroundings, table: "Table", heavy: bool = False) -> list[Limits]:
    """Return the limits of a table's fields; `heavy` includes heavy columns."""
    key = (*table.columns, *table.dims.values())
    known = table.limits.get(heavy)
    if known is None or known[0] != key:
        known = table.limits[heavy] = key, list(_limits(world, table, heavy))
    return known[1]


def _look(world: Surroundings, known: Looked | None) -> Looked:
    """Return the fields to check: `known`, unless a table or column has been replaced."""
    tables = tuple(world.tables.values())
    key = [Columns.replaced, len(world.causes), *tables, *[table.dims for table in tables]]
    if known is not None and known.key == key:
        return known
    entries: dict[Any, list[tuple[int, np.ndarray, Any, Any]]] = {}
    limits: dict[Any, list[Limits | None]] = {}
    for i, table in enumerate(tables):
        ours = [
            (one, table.field(one.component, one.field), one.low, one.high) for one in limits_of(world, table)
        ]
        for one, column, low, high in [*ours, (None, table.cause, 0, min(255, len(world.causes)))]:
            entries.setdefault(column.dtype, []).append((i, column, low, high))
            limits.setdefault(column.dtype, []).append(one)
    key[2 + len(tables) :] = [table.dims.copy() for table in tables]
    groups = [scan.ColumnGroup.of(each) for each in entries.values()]
    return Looked(key, tables, groups, list(limits.values()))


def _limits(world: Surroundings, table: "Table", heavy: bool) -> Iterator[Limits]:
    lengths = dict(zip("xyz", world.space.size, strict=False))
    component: Any
    for component in table.columns:
        for field, kind, low, high in _declared(component, heavy):
            if component.__name__ == "Position" and (length := lengths.get(field)) is not None:
                near = np.nextafter(np.float32(length), np.float32(0))
                yield Limits(
                    component, field, np.float32(0), near, length, world.space.torus and field != "z"
                )
                continue
            if component.__name__ == "Position" and field == "heading":
                yield Limits(component, field, np.float32(0), TURN, 2 * np.pi, True)
                continue
            high = table.dims.get(high) if isinstance(high, str) else high
            if high is not None:
                yield Limits(component, field, low, kind.dtype.type(high))


@lru_cache(256)
def _declared(component: type[Any], heavy: bool) -> list[tuple[str, Any, Any, Any]]:
    """Return the checked fields of a component with their types and declared limits (None: no limits); they
    are the same in every table."""
    out = []
    for field, (kind, default) in component.fields.items():
        # if the default is not finite, any number is allowed
        if (kind.blocked and not heavy) or not np.isfinite(default).all():
            continue
        low, high = kind.limits or (None, None)
        if kind.limits is not None:
            low = kind.dtype.type(low)
        elif kind.dtype.kind == "f":
            low, high = np.finfo(kind.dtype).min, np.finfo(kind.dtype).max
        out.append((field, kind, low, high))
    return out


def admit(world: Surroundings, refuse: bool = True, known: Looked | None = None) -> Looked:
    """Wrap or reject the values written since the last tick: columns of living organisms, fields, ground,
    ambient values and requested births.

    Returns the checked fields; passing them to the next call saves time. Raises a ValueError that names the
    organism, the field, the value and the limits, unless debug mode will raise it.
    """
    if refuse:
        check_surroundings(world)
    looked = _look(world, known)
    rows = scan.rows_of(looked.tables)
    for columns, limits in zip(looked.columns, looked.limits, strict=True):
        at = -1
        while (at := columns.first_outside(at + 1, rows)) >= 0:
            table, one = looked.tables[columns.table[at]], limits[at]
            if one is not None:
                _admit_column(table, one, table.field(one.component, one.field), refuse)
            elif refuse:
                _refuse_cause(table, len(world.causes))
    for table in looked.tables:
        for parents, _, values in table.births:
            values.update(newborn(world, table, values, f"newborn {{}} of {parents.size} of {table.name!r}"))
    return looked


def _refuse_cause(table: "Table", known: int) -> None:
    row = int(np.flatnonzero(table.cause > known)[0])
    raise ValueError(
        f"{table.name}, uid {int(table.uid[row])}: cause of death {int(table.cause[row])}; "
        f"expected: 0 to {known}, as returned by world.cause(name)"
    )


def _admit_column(table: "Table", limits: Limits, column: np.ndarray, refuse: bool) -> None:
    rows = table.rows()
    wrong = limits.outside(column[rows])
    if wrong.any() and limits.length:
        column[rows] = limits.brought_back(column[rows])
        table.version += 1
        wrong = limits.outside(column[rows])
    if wrong.any() and refuse:
        limits.refuse(f"{table.name}, uid {int(table.uid[rows[wrong][0]])}", column[rows[wrong]])


def newborn(
    world: Surroundings, table: "Table", values: Mapping[tuple[type, str], Any], label: str
) -> dict[tuple[type, str], np.ndarray]:
    """Return the columns of newborns with their positions wrapped into the space. Raises a ValueError for
    values beyond their limits.

    `label` names the newborn in the message, with {} for the index of the first invalid one.
    """
    out = {}
    for limits in limits_of(world, table, heavy=True):
        key = limits.component, limits.field
        if key in values:
            given = np.asarray(values[key])
            if limits.length:
                given = limits.brought_back(given.astype(np.float32, copy=False))
            limits.refuse(label, given)
            out[key] = given
    return {**values, **out}


def one_each(value: ArrayLike, n: int, where: str) -> np.ndarray:
    """Return the result of a user-defined function for n positions as an array of n numbers. Raises a
    ValueError for any other result."""
    array = np.asarray(value)
    if array.dtype.kind not in "fiub" or array.shape not in ((), (n,)):
        raise ValueError(
            f"{where} gives {array.dtype}{list(array.shape)}; expected: {n} numbers, one for each place"
        )
    return array if array.ndim else np.full(n, array, np.float32)
