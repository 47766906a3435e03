"""The gate: what comes into a world from outside is a finite number within its limits, is brought there,
or is refused by name.

Outside is everything that no system of a tick wrote: spawned organisms, what was written to columns, handles,
fields and ground between ticks, checkpoints, interventions. A place beyond the edge of a torus is wrapped
around it, one on a wall moved to just before it. Within a tick nothing is checked: kernels stay within their
arrays whatever the numbers are, and the debug mode says which system wrote a bad one.
"""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.engine.table import first_outside
from ecs_eco.space.check_surroundings import check_surroundings
from ecs_eco.space.geometry import back_into

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

# lengths of the world from which a place is wrapped around a torus: float32 still resolves places there
FURTHEST = 1000
WIDTH = 8  # columns of a group: more would save little, and stay empty in small tables


class Limits(NamedTuple):
    """What a field of a component may hold in one table: low to high, both allowed;
    `length` [m] is that of an axis of the space."""

    component: type[Any]
    field: str
    low: Any
    high: Any
    length: float = 0.0  # 0: no place along an axis
    around: bool = False  # whether it goes around

    @property
    def name(self) -> str:
        """Component.field, as in messages."""
        return f"{self.component.__name__}.{self.field}"

    @property
    def allowed(self) -> str:
        """The limits in words."""
        if self.length:
            back = (f"; up to ±{FURTHEST * self.length:g} m is brought back around the torus"
                    if self.around else "")
            return f"0 to {self.length:g} m{back}"
        if self.high in (np.finfo(np.float32).max, np.finfo(np.float64).max):
            return "finite numbers"
        return f"{self.low:g} to {self.high:g}"

    def outside(self, values: np.ndarray) -> np.ndarray:
        """Return which of values [k, …] are beyond the limits or not finite: bool[k]."""
        wrong = ~((values >= self.low) & (values <= self.high))
        return wrong.any(axis=tuple(range(1, wrong.ndim)))

    def brought_back(self, values: np.ndarray) -> np.ndarray:
        """Return places f32[k] [m], brought into the space where that is possible; others unchanged."""
        if self.around:
            can = np.abs(values) <= FURTHEST * np.float32(self.length)
        else:
            can = values == np.float32(self.length)
        return np.where(can, back_into(np.where(can, values, 0), self.length, self.around),
                        values).astype(np.float32)

    def refuse(self, label: str, values: np.ndarray) -> None:
        """Raise ValueError if a value is outside; `label` says whose it is,
        with {} for the row of the first one."""
        rows = np.flatnonzero(self.outside(values))
        if rows.size:
            bad = np.atleast_1d(values[rows[0]])
            inside = np.atleast_1d((bad >= self.low) & (bad <= self.high)).ravel()
            value = bad.ravel()[np.flatnonzero(~inside)[0]]
            more = f" ({rows.size - 1} more)" if rows.size > 1 else ""
            raise ValueError(f"{label.format(int(rows[0]))}: {self.name} is {value}{more}; allowed: "
                             f"{self.allowed}")


class Group(NamedTuple):
    """Limits of up to WIDTH columns of one type, looked at in one call;
    the rest of a group repeats the first, with no values."""

    limits: list[Limits]
    each: np.ndarray  # i64[k] values of one organism
    low: np.ndarray  # [k]
    high: np.ndarray  # [k]


class _Known(NamedTuple):
    key: tuple[Any, ...]  # what the limits were computed from
    limits: list[Limits]
    groups: list[Group]


def limits_of(world: Any, table: "Table", heavy: bool = False) -> list[Limits]:
    """Return the limits of a table's fields, with `heavy` of heavy ones too."""
    return _known(world, table, heavy).limits


def _known(world: Any, table: "Table", heavy: bool) -> _Known:
    key = (*table.columns, *table.dims.values())
    known = table.limits.get(heavy)
    if known is None or known.key != key:
        limits = list(_limits(world, table, heavy))
        known = table.limits[heavy] = _Known(key, limits, list(_groups(table, limits)))
    return known


def _groups(table: "Table", limits: list[Limits]) -> Iterator[Group]:
    """Yield limits by type; groups of all tables have one size, so that their kernel is compiled once."""
    for dtype in dict.fromkeys(one.low.dtype for one in limits):
        same = [one for one in limits if one.low.dtype == dtype]
        for at in range(0, len(same), WIDTH):
            group = same[at : at + WIDTH]
            each = [math.prod(table.field(one.component, one.field).shape[1:]) for one in group]
            if len(same) > 1:
                each += [0] * (WIDTH - len(group))
                group += group[:1] * (WIDTH - len(group))
            low, high = (np.array([getattr(one, end) for one in group], dtype) for end in ("low", "high"))
            yield Group(group, np.array(each, np.int64), low, high)


def _limits(world: Any, table: "Table", heavy: bool) -> Iterator[Limits]:
    lengths = dict(zip("xyz", world.space.size, strict=False))
    for component in table.columns:
        for field, (kind, default) in component.fields.items():
            # its default is not finite: any number is allowed
            if (kind.blocked and not heavy) or not np.isfinite(default).all():
                continue
            if component.__name__ == "Position" and (length := lengths.get(field)) is not None:
                near = np.nextafter(np.float32(length), np.float32(0))
                yield Limits(component, field, np.float32(0), near, length,
                             world.space.torus and field != "z")
            elif kind.limits is not None:
                low, high = kind.limits
                high = table.dims.get(high) if isinstance(high, str) else high
                if high is not None:
                    yield Limits(component, field, kind.dtype.type(low), kind.dtype.type(high))
            elif kind.dtype.kind == "f":
                yield Limits(component, field, np.finfo(kind.dtype).min, np.finfo(kind.dtype).max)


def admit(world: Any, refuse: bool = True) -> None:
    """Wrap or refuse what was written since the last tick: columns of the living, fields, ground,
    ambient values, requested births.

    Raises ValueError that names the organism, the field, the value and the limits;
    does not raise where the debug mode will.
    """
    if refuse:
        check_surroundings(world)
    for table in world.tables.values():
        if table.n:
            _admit_living(world, table, refuse)
        for parents, _, values in table.births:
            values.update(newborn(world, table, values, f"newborn {{}} of {parents.size} of {table.name!r}"))


def _admit_living(world: Any, table: "Table", refuse: bool) -> None:
    for group in _known(world, table, heavy=False).groups:
        arrays = [getattr(table.columns[limits.component], limits.field) for limits in group.limits]
        flat, at = tuple([array if array.ndim == 1 else array.reshape(-1) for array in arrays]), -1
        while (at := first_outside(flat, at + 1, table.high, group.each, group.low, group.high)) >= 0:
            _admit_column(table, group.limits[at], arrays[at], refuse)
    if refuse and table.cause[: table.high].max(initial=0) > len(world.causes):
        row = int(np.flatnonzero(table.cause > len(world.causes))[0])
        raise ValueError(f"{table.name}, uid {int(table.uid[row])}: cause of death {int(table.cause[row])}; "
                         f"allowed: 0 to {len(world.causes)}, as world.cause(name) gives them")


def _admit_column(table: "Table", limits: Limits, column: np.ndarray, refuse: bool) -> None:
    rows = table.rows()
    wrong = limits.outside(column[rows])
    if wrong.any() and limits.length:
        column[rows] = limits.brought_back(column[rows])
        table.version += 1
        wrong = limits.outside(column[rows])
    if wrong.any() and refuse:
        limits.refuse(f"{table.name}, uid {int(table.uid[rows[wrong][0]])}", column[rows[wrong]])


def newborn(world: Any, table: "Table", values: Mapping[tuple[type, str], Any],
            label: str) -> dict[tuple[type, str], np.ndarray]:
    """Return the columns of newborn with their places brought into the space;
    ValueError for what is beyond its limits.

    `label` says in the message who they are, with {} for the number of the first one.
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


def one_each(value: Any, n: int, where: str) -> np.ndarray:
    """Return what a function of a user's own gave for n places as an array of n numbers, one for all
    repeated; ValueError otherwise."""
    array = np.asarray(value)
    if array.dtype.kind not in "fiub" or array.shape not in ((), (n,)):
        raise ValueError(f"{where} gives {array.dtype}{list(array.shape)}; allowed: {n} numbers, "
                         "one for each place")
    return array if array.ndim else np.full(n, array, np.float32)
