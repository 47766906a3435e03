"""A table holds all entities of one kind: an array per component field, rows stable for life, an alive mask."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NoReturn, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ecs_eco._html import of_entities
from ecs_eco.engine.blocks import Blocked
from ecs_eco.engine.errors import UnknownName, no_attribute, unknown_name
from ecs_eco.engine.noted import Noted
from ecs_eco.engine.rows import FEW, ROWS, Layout, list_dying, occupy, vacate
from ecs_eco.engine.schema import Columns, Handle, Type

Values = Mapping[tuple[type, str], Any]
# births of one call: first and second parents, u64[k], and the columns of the newborn
Request = tuple[np.ndarray, np.ndarray | None, dict[tuple[type, str], np.ndarray]]
MOST_BATCHES = 64  # of newborn and dead that are noted
ALIVE = bytes(1 << 20)  # the causes of death of so many who live, to compare with
NOBODY = np.empty(0, np.int64)
NO_LAYOUT = Layout()


class Onlooker(Protocol):
    """Somebody outside who keeps what stands in the rows of tables."""

    stale: bool  # set when somebody is born, dies or moves to another row

    def renew(self, table: Table) -> None:
        """Look at handles anew: rows or columns of a table are others."""

    def empty(self, table: Table) -> None:
        """Forget all that is kept of a table."""


class Table(dict[type, Any]):
    """The columns of one kind of entity: a dict of its components, that only the table itself writes.

    `alive` bool[capacity]; `uid` u64[capacity], 0 in free rows; `born` i64[capacity], the tick of birth;
    `cause` u8[capacity], not 0 in the rows that die at the end of the phase `die`; `killer` u64[capacity].
    `table[Position].x` is a column. Columns move when the table grows: keep none past the tick. `columns` are
    the components that are kept, `derived` those that are made of other things when somebody looks.
    """

    # without these, each reading of an attribute of a dict takes three times as long
    __slots__ = (
        "__dict__",
        "__weakref__",
        "_laid_out",
        "_layout",
        "alive",
        "along",
        "births",
        "born",
        "capacity",
        "cause",
        "columns",
        "defaults",
        "derived",
        "dims",
        "followed",
        "gone",
        "high",
        "killer",
        "limits",
        "n",
        "name",
        "newborn",
        "onlooker",
        "own",
        "place",
        "species",
        "steady",
        "uid",
        "version",
    )
    __hash__, __eq__ = object.__hash__, object.__eq__  # type: ignore[assignment]  # each is itself alone

    def __init__(
        self,
        name: str,
        components: Iterable[type[Any]],
        *,
        capacity: int = 64,
        dims: Mapping[str, int] | None = None,
        place: int = 0,
    ) -> None:
        if capacity < 1:
            raise ValueError(f"table {name!r}: capacity is {capacity}; it must be at least 1")
        self.name = name
        self.place = place  # its number in the world
        self.dims = dict(dims or {})
        self.capacity = int(capacity)
        self.n = 0  # entities alive
        self.high = 0  # this row and all after it are free
        self.version = 0  # changes when a place or the set of the living does
        self.steady = (-1, -1)  # two versions between which nothing but births and deaths took effect
        self.newborn: list[tuple[int, np.ndarray, np.ndarray]] = []  # since then: version, rows, uids
        self.followed = False  # whether an index of neighbours wants to know who was born and who died
        self.gone: list[tuple[int, np.ndarray, np.ndarray]] = []  # the same of those who left
        self.alive = np.zeros(capacity, np.bool_)
        self.uid = np.zeros(capacity, np.uint64)
        self.born = np.zeros(capacity, np.int64)
        self.cause = np.zeros(capacity, np.uint8)
        self.killer = np.zeros(capacity, np.uint64)
        self.along: dict[str, np.ndarray] = {}  # arrays of others by row, which grow and are reordered too
        self.onlooker: Onlooker | None = None
        self.columns: Noted[type[Any], Columns] = Noted()
        self.derived: Noted[type[Any], Columns] = Noted()
        self.columns.follow = self.derived.follow = _following(weakref.ref(self))
        self.defaults: dict[type[Any], dict[str, np.ndarray]] = Noted()
        self._layout = NO_LAYOUT  # as it was found last
        self._laid_out: tuple[Any, ...] = ()  # from what
        self.births: list[Request] = []
        self.limits: dict[bool, Any] = {}  # of its fields, as the gate knows them
        self.species: Any = None  # what all entities of the table share: a `life.kind.Kind` in an ecosystem
        self.own: dict[str, Any] = {}  # for systems of your own: saved if it has state() and load()
        for component in components:
            self.add_component(component)

    def __repr__(self) -> str:
        return f"<Table {self.name!r}: {self.n} alive, {', '.join(c.__name__ for c in self.columns)}>"

    def _repr_html_(self) -> str:
        return of_entities(self.name, self.uid, self.rows(), self.columns)

    def __len__(self) -> int:
        return self.n

    def __missing__(self, component: object) -> NoReturn:
        known = [c.__name__ for c in (*self.columns, *self.derived)]
        raise UnknownName(
            unknown_name(
                f"table {self.name!r}", "component", getattr(component, "__name__", component), known
            )
        )

    def __getattr__(self, name: str) -> NoReturn:
        raise AttributeError(name if name in Table.__slots__ else no_attribute(self, name))

    def __setitem__(self, component: object, columns: object) -> NoReturn:
        raise TypeError(
            f"table {self.name!r}: its components are not replaced; write into their columns, "
            "as in table[Position].x[rows] = …"
        )

    def has(self, components: Iterable[type]) -> bool:
        """Return whether the table has all these components."""
        return self.keys() >= set(components)

    def add_component(self, component: type[Any], **defaults: ArrayLike) -> None:
        """Give every entity, living or to come, a component; `defaults` replace the component's own."""
        if not (isinstance(component, type) and issubclass(component, Handle) and component.fields):
            raise TypeError(
                f"table {self.name!r}: {component!r} is not a component; declare it with @component"
            )
        if component in self.derived:
            raise ValueError(
                f"table {self.name!r} has {component.__name__} already: it is made of what organisms sense"
            )
        if component in self.columns:
            self.set_defaults(component, **defaults)
            return
        columns, values = Columns(), {}
        for field, (kind, default) in component.fields.items():
            shape = kind.resolve(self.dims, f"{component.__name__}.{field} in table {self.name!r}")
            values[field] = np.broadcast_to(np.asarray(default, kind.dtype), shape).copy()
        self.defaults[component] = Noted(values)
        self.set_defaults(component, **defaults)
        for field, value in values.items():
            setattr(columns, field, _column(component.fields[field][0], value, self.capacity, self.rows()))
        self.columns[component] = columns
        self.renew_handles()

    def renew_handles(self) -> None:
        """Let handles that others keep be looked at anew: rows or columns are others."""
        if self.onlooker is not None:
            self.onlooker.renew(self)

    def set_defaults(self, component: type[Any], **defaults: ArrayLike) -> None:
        """Set what a newborn of this table has in these fields."""
        for field, value in defaults.items():
            if field not in component.fields:
                raise UnknownName(
                    unknown_name(
                        f"{component.__name__} in table {self.name!r}", "field", field, component.fields
                    )
                )
            self.defaults[component][field][...] = value

    def field(self, component: type[Any], name: str) -> np.ndarray:
        """Return one column: an array [capacity, …]."""
        return getattr(self[component], name)

    def rows(self) -> np.ndarray:
        """Return the living rows, ascending: i64[n]."""
        return np.flatnonzero(self.alive[: self.high])

    def by_uid(self) -> np.ndarray:
        """Return the living rows in the order of their uids: i64[n]."""
        rows = self.rows()
        return rows[np.argsort(self.uid[rows], kind="stable")]

    def reserve(self, n: int) -> None:
        """Make room for `n` rows in all, at least doubling the columns when they are too short."""
        if n <= self.capacity:
            return
        new = max(n, 2 * self.capacity)
        for name in ROWS:
            setattr(self, name, _grown(getattr(self, name), new))
        for name, array in self.along.items():
            self.along[name] = _grown(array, new)
        for columns in self.columns.values():
            for field, array in list(vars(columns).items()):
                setattr(columns, field, array.grow(new) if isinstance(array, Blocked) else _grown(array, new))
        self.capacity = new
        Columns.replaced = object()  # also where there are no columns: addresses of rows are others

    def layout(self) -> Layout:
        """Return where the arrays are in memory, as kernels take them."""
        if self._laid_out != (now := (Noted.changes, Columns.replaced)):
            self._layout, self._laid_out = (
                self._layout.renewed([getattr(self, name) for name in ROWS], self.columns, self.defaults),
                now,
            )
        return self._layout

    def request(
        self,
        parents: np.ndarray,
        values: Mapping[tuple[type, str], np.ndarray],
        second: np.ndarray | None = None,
    ) -> None:
        """Ask for one birth per entry of `parents` (u64[k], 0 for none);
        they take effect at the end of `reproduce`.

        `values[(Component, field)]` is an array [k, …] of what differs from the table's defaults. Requests
        must come in an order that does not depend on rows (by parent uid, say): newborn get their uids in
        this order. Raises KeyError for a component or field that the table lacks, ValueError for a shape that
        does not fit.
        """
        n, shapes = len(parents), self.layout().shapes
        flat = (n,)
        for key, array in values.items():
            if (one := shapes.get(key)) is None:
                self._refuse(*key)
            shape = array.shape if type(array) is np.ndarray else np.shape(array)
            if shape != (flat + one if one else flat):
                where = f"newborn of {self.name!r}: {key[0].__name__}.{key[1]}"
                raise ValueError(f"{where} has the shape {shape}; allowed is {(n, *one)}")
        self.births.append((parents, second, dict(values)))

    def _refuse(self, component: type[Any], name: str) -> NoReturn:
        """Raise what is wrong with a field that newborn are to have."""
        if component in self.derived:
            raise TypeError(
                f"newborn of {self.name!r}: {component.__name__} is read, not written: nobody is born with it"
            )
        known = self.defaults[component] if component in self.columns else self[component]
        raise UnknownName(unknown_name(f"{component.__name__} in table {self.name!r}", "field", name, known))

    def occupy(self, k: int, first_uid: int, tick: int, values: Values, whole: bool = True) -> np.ndarray:
        """Bring `k` entities to life in the lowest free rows, with uids from `first_uid` on; return their
        rows. Where they are not `whole`, fields of which there are no values keep what was in those rows."""
        if self.n + k > self.capacity:
            self.reserve(self.n + k)
        layout, rows = self.layout(), np.empty(k, np.int64)
        self.high = occupy(
            rows,
            self.capacity,
            layout.rows,
            first_uid,
            tick,
            self.high,
            layout.columns if whole else NO_LAYOUT.columns,
        )
        self.n += k
        self._goes_on(self.newborn, rows)
        if self.onlooker is not None:
            self.onlooker.stale = True
        for component, field in layout.others if whole else ():
            layout.fields[component, field][rows] = self.defaults[component][field]
        for key, array in values.items():
            if (column := layout.fields.get(key)) is not None:
                column[rows] = array
        return rows

    def settle(self, uid: np.ndarray, born: np.ndarray, values: Values, whole: bool = True) -> np.ndarray:
        """Bring entities that come from elsewhere to life in the lowest free rows, with their uids u64[k] and
        ticks of birth i64[k]; return their rows. Where they are not `whole`, fields of which there are no
        values are those of who was there before: nobody may read them."""
        rows = self.occupy(uid.size, 0, 0, values, whole)
        self.uid[rows], self.born[rows] = uid, born
        self.steady = (-1, -1)  # those of newborn are larger than all others, these need not be
        return rows

    def doomed(self) -> np.ndarray:
        """Return the rows that have a cause of death, ascending: i64[k]."""
        cause = self.cause if self.high == self.capacity else self.cause[: self.high]
        if ALIVE.startswith(cause.data):
            return NOBODY
        return (cause if self.high < 1000 else cause != 0).nonzero()[0]  # that of many numbers is slow

    def dying(self) -> np.ndarray:
        """Return the rows that have a cause of death, in the order of uids: i64[k]."""
        cause = self.cause if self.high == self.capacity else self.cause[: self.high]
        if ALIVE.startswith(cause.data):
            return NOBODY
        rows = np.empty(FEW + self.high // 16, np.int64)
        if (n := list_dying(rows, self.high, self.layout().rows)) > rows.size:
            rows = np.empty(n, np.int64)
            list_dying(rows, self.high, self.layout().rows)
        rows = rows[:n]
        return rows if n <= FEW else rows.take(self.uid.take(rows).argsort())

    def vacate(self, rows: np.ndarray) -> None:
        """Free the rows of the dead."""
        self._goes_on(self.gone, rows)
        self.high = vacate(rows, self.capacity, self.layout().rows, self.high)
        self.n -= rows.size
        if self.onlooker is not None:
            self.onlooker.stale = True

    def note_freed(self, n: int, high: int) -> None:
        """Know that a kernel has freed `n` rows, and that this row and all after it are free now."""
        self.high, self.n, self.version = high, self.n - n, self.version + 1
        if self.onlooker is not None:
            self.onlooker.stale = True

    def _goes_on(self, which: list[tuple[int, np.ndarray, np.ndarray]], rows: np.ndarray) -> None:
        """Count a version that differs from the last by births or deaths of these rows alone."""
        if not self.followed:
            self.version += 1
            return
        first, last = self.steady
        if last != self.version or len(self.newborn) + len(self.gone) >= MOST_BATCHES:
            first = self.version
            self.newborn.clear()
            self.gone.clear()
        self.version += 1
        if 4 * rows.size > self.n:  # nobody wants to know: to begin anew is as fast
            self.steady = (-1, -1)
        else:
            if rows.size:
                which.append((self.version, rows, self.uid.take(rows)))
            self.steady = first, self.version

    def reorder(self, rows: np.ndarray) -> None:
        """Move the entity of row `rows[i]` to row i, for all living; this changes no organism's fate.

        Data that systems keep by row moves too, if it has a method `reorder(order)`: row i then holds what
        row `order[i]` did. Raises ValueError where `rows` are not the living rows, each once.
        """
        rows = np.asarray(rows, np.int64)
        if not np.array_equal(np.sort(rows), self.rows()):
            raise ValueError(
                f"table {self.name!r}: reorder takes its {self.n} living rows, each once; "
                f"here are {rows.size} others"
            )
        rest = np.setdiff1d(np.arange(self.capacity), rows)
        order = np.concatenate([rows, rest])
        for name in ROWS:
            setattr(self, name, getattr(self, name)[order])
        for name, array in self.along.items():
            self.along[name] = array[order]
        for columns in self.columns.values():
            for field, array in list(vars(columns).items()):
                if isinstance(array, Blocked):
                    array[: self.n] = array[rows]
                else:
                    setattr(columns, field, array[order])
        Columns.replaced = object()  # also where there are no columns: addresses of rows are others
        self.renew_handles()
        for part in self.parts().values():
            if callable(getattr(part, "reorder", None)):
                part.reorder(order)
        self.high = self.n
        self.version += 1

    @property
    def waiting(self) -> int:
        """Number of births that were requested and have not taken effect yet."""
        return sum(parents.size for parents, _, _ in self.births)

    def parts(self) -> dict[str, Any]:
        """Return, by name, what all entities share and may have a state of its own."""
        return (self.species.parts() if self.species is not None else {}) | self.own

    @property
    def nbytes(self) -> int:
        """Bytes of all columns."""
        own = sum(array.nbytes for array in (*(getattr(self, a) for a in ROWS), *self.along.values()))
        return own + sum(a.nbytes for c in self.columns.values() for a in vars(c).values())


def _following(table: Callable[[], Table | None]) -> Callable[[], None]:
    """Return what lets a table be the dict of its columns and what is derived, as they are now."""

    def follow() -> None:
        if (it := table()) is not None:
            dict.clear(it)
            dict.update(it, it.columns | it.derived)

    return follow


def _column(kind: Type, value: np.ndarray, capacity: int, living: np.ndarray) -> Any:
    """Return a new column with this default in every row; a heavy one holds it in the rows of the living only."""
    if not kind.blocked:
        return np.broadcast_to(value, (capacity, *value.shape)).copy()
    column = Blocked(value.shape, kind.dtype).grow(capacity)
    if living.size:
        column[living] = value
    return column


def _grown(array: np.ndarray, n: int) -> np.ndarray:
    out = np.zeros((n, *array.shape[1:]), array.dtype)
    out[: array.shape[0]] = array
    return out
