"""A table contains all entities of one kind: one array per component field, a fixed row per entity, and an
alive mask."""

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
from ecs_eco.engine.rows import ROWS, Layout, occupy, vacate
from ecs_eco.engine.schema import Columns, Handle, Type

Values = Mapping[tuple[type, str], Any]
# one request for births: first and second parents, u64[k], and the newborns' columns
Request = tuple[np.ndarray, np.ndarray | None, dict[tuple[type, str], np.ndarray]]
NO_LAYOUT = Layout()


class Onlooker(Protocol):
    """An observer outside the engine that caches the content of table rows."""

    stale: bool  # set when an entity is born, dies or moves to another row

    def renew(self, table: Table) -> None:
        """Update handles after a table's rows or columns have changed."""

    def empty(self, table: Table) -> None:
        """Discard everything that is cached for a table."""


class Table(dict[type, Any]):
    """The columns of one kind of entity: `table[Position].x` is an array with one row per entity.

    A table is a read-only dict of its components. `World.add_table` creates one.

    Attributes
    ----------
    n : int
        Number of living entities.
    alive : array of bool, shape (capacity,)
        Which rows are in use.
    uid : array of uint64, shape (capacity,)
        Each organism's lifelong identity; 0 in free rows.
    born : array of int64, shape (capacity,)
        Tick of birth.
    cause : array of uint8, shape (capacity,)
        Cause of death, from `World.cause`; an organism with a cause dies at the end of the `die` phase.
    killer : array of uint64, shape (capacity,)
        uid of the organism that killed it; 0 if there is none.
    version : int
        Changes when a position or the set of living entities changes; add 1 after moving bodies.
    species : Kind
        Values that all entities of the table share, such as `table.species.metabolism.basal` from the world
        file.

    Notes
    -----
    Columns are replaced when the table grows: never hold one across ticks.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.components import Metabolism
    >>> table = World.from_config("predator-prey", seed=1).table("deer")
    >>> table.n
    700
    >>> table[Metabolism].energy[table.alive].dtype
    dtype('float32')
    """

    # without slots, reading an attribute of a dict takes three times as long
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
        "high",
        "killer",
        "limits",
        "n",
        "name",
        "onlooker",
        "own",
        "place",
        "species",
        "uid",
        "version",
    )
    __hash__, __eq__ = object.__hash__, object.__eq__  # type: ignore[assignment]  # by identity

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
        self.place = place  # its index in the world
        self.dims = dict(dims or {})
        self.capacity = int(capacity)
        self.n = 0  # living entities
        self.high = 0  # this row and all after it are free
        self.version = 0  # changes when a position or the set of living entities changes
        self.alive = np.zeros(capacity, np.bool_)
        self.uid = np.zeros(capacity, np.uint64)
        self.born = np.zeros(capacity, np.int64)
        self.cause = np.zeros(capacity, np.uint8)
        self.killer = np.zeros(capacity, np.uint64)
        self.along: dict[str, np.ndarray] = {}  # arrays that other objects keep by row
        self.onlooker: Onlooker | None = None
        self.columns: Noted[type[Any], Columns] = Noted()
        self.derived: Noted[type[Any], Columns] = Noted()
        self.columns.follow = self.derived.follow = _following(weakref.ref(self))
        self.defaults: dict[type[Any], dict[str, np.ndarray]] = Noted()
        self._layout = NO_LAYOUT  # the most recent one
        self._laid_out: tuple[Any, ...] = ()  # the state from which it was derived
        self.births: list[Request] = []
        self.limits: dict[bool, Any] = {}  # limits of the table's fields, for the gate
        self.species: Any = None  # values that all entities share: a `life.kind.Kind` in an ecosystem
        self.own: dict[str, Any] = {}  # for custom systems; saved if it has state() and load()
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
            f"table {self.name!r}: components cannot be replaced; write to their columns, "
            "as in table[Position].x[rows] = …"
        )

    def has(self, components: Iterable[type]) -> bool:
        """Return whether the table has all these components.

        Parameters
        ----------
        components : iterable of type

        Returns
        -------
        bool

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Metabolism, Position
        >>> World().add_table("rock", Position).has([Position, Metabolism])
        False
        """
        return self.keys() >= set(components)

    def add_component(self, component: type[Any], **defaults: ArrayLike) -> None:
        """Give a component to all current and future entities.

        Parameters
        ----------
        component : type
            A class decorated with `component`.
        **defaults
            Field values that replace the component's defaults.

        Raises
        ------
        TypeError
            If the class is not a component.
        UnknownName
            If a field is unknown.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Metabolism, Position
        >>> hares = World().add_table("hare", Position)
        >>> hares.add_component(Metabolism, energy=0.5)
        >>> hares
        <Table 'hare': 0 alive, Position, Metabolism>
        """
        if not (isinstance(component, type) and issubclass(component, Handle) and component.fields):
            raise TypeError(
                f"table {self.name!r}: {component!r} is not a component; declare it with @component"
            )
        if component in self.derived:
            raise ValueError(
                f"table {self.name!r} already has {component.__name__}, which is derived from what organisms sense"
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
        """Update cached handles after rows or columns have changed."""
        if self.onlooker is not None:
            self.onlooker.renew(self)

    def set_defaults(self, component: type[Any], **defaults: ArrayLike) -> None:
        """Set default field values for newborns of this table.

        Parameters
        ----------
        component : type
            A component of the table.
        **defaults
            Values by field.

        Raises
        ------
        UnknownName
            If a field is unknown.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Metabolism
        >>> world = World()
        >>> hares = world.add_table("hare", Metabolism)
        >>> hares.set_defaults(Metabolism, energy=0.25)
        >>> world.spawn("hare")
        >>> world.flush()
        >>> world.get(1, Metabolism).energy
        0.25
        """
        for field, value in defaults.items():
            if field not in component.fields:
                raise UnknownName(
                    unknown_name(
                        f"{component.__name__} in table {self.name!r}", "field", field, component.fields
                    )
                )
            self.defaults[component][field][...] = value

    def field(self, component: type[Any], name: str) -> np.ndarray:
        """Return one column.

        Parameters
        ----------
        component : type
        name : str
            Name of the field.

        Returns
        -------
        array, shape (capacity, …)

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Position
        >>> World().add_table("hare", Position, capacity=8).field(Position, "x").shape
        (8,)
        """
        return getattr(self[component], name)

    def rows(self) -> np.ndarray:
        """Return the rows of living entities in ascending order.

        Returns
        -------
        array of int64, shape (n,)

        Examples
        --------
        >>> from ecs_eco import World
        >>> World.from_config("predator-prey", seed=1).table("wolf").rows()[:3].tolist()
        [0, 1, 2]
        """
        return np.flatnonzero(self.alive[: self.high])

    def by_uid(self) -> np.ndarray:
        """Return the rows of living entities, sorted by uid.

        Returns
        -------
        array of int64, shape (n,)

        Examples
        --------
        >>> from ecs_eco import World
        >>> wolves = World.from_config("predator-prey", seed=1).table("wolf")
        >>> len(wolves.by_uid()) == wolves.n
        True
        """
        rows = self.rows()
        return rows[np.argsort(self.uid[rows], kind="stable")]

    def reserve(self, n: int) -> None:
        """Reserve `n` rows in total; columns that are too short at least double in length."""
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
        Columns.replaced = object()  # even without columns, because row addresses have changed

    def layout(self) -> Layout:
        """Return the addresses of the arrays for kernels."""
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
        """Request births, which take effect at the end of the `reproduce` phase.

        Parameters
        ----------
        parents : array of uint64, shape (k,)
            uid of the first parent of each newborn; 0 for none.
        values : Mapping of (type, str) to array, shape (k, …)
            Columns by component and field, for values that differ from the table's defaults.
        second : array of uint64, shape (k,), optional
            uid of the second parent.

        Raises
        ------
        KeyError
            If the table lacks a component or field.
        ValueError
            If an array has the wrong shape.

        Notes
        -----
        Newborns get their uids in request order. This order must therefore not depend on rows; you
        can sort requests by the uids of parents.

        Examples
        --------
        >>> import numpy as np
        >>> from ecs_eco import World
        >>> from ecs_eco.components import Metabolism
        >>> world = World()
        >>> hares = world.add_table("hare", Metabolism)
        >>> hares.request(np.zeros(2, np.uint64), {(Metabolism, "energy"): np.array([0.2, 0.4], np.float32)})
        >>> world.flush()
        >>> hares.n
        2
        """
        n, shapes = len(parents), self.layout().shapes
        flat = (n,)
        for key, array in values.items():
            if (one := shapes.get(key)) is None:
                self._refuse(*key)
            shape = array.shape if type(array) is np.ndarray else np.shape(array)
            if shape != (flat + one if one else flat):
                where = f"newborns of {self.name!r}: {key[0].__name__}.{key[1]}"
                raise ValueError(f"{where} has shape {shape}; expected {(n, *one)}")
        self.births.append((parents, second, dict(values)))

    def _refuse(self, component: type[Any], name: str) -> NoReturn:
        """Raise the error for a field that cannot be set for newborns."""
        if component in self.derived:
            raise TypeError(f"newborns of {self.name!r}: {component.__name__} is read-only and cannot be set")
        known = self.defaults[component] if component in self.columns else self[component]
        raise UnknownName(unknown_name(f"{component.__name__} in table {self.name!r}", "field", name, known))

    def occupy(self, k: int, first_uid: int, tick: int, values: Values, whole: bool = True) -> np.ndarray:
        """Add `k` living entities in the lowest free rows, with uids starting at `first_uid`; return their
        rows. Unless `whole`, fields without values keep the row's previous content."""
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
        self.version += 1
        if self.onlooker is not None:
            self.onlooker.stale = True
        for component, field in layout.others if whole else ():
            layout.fields[component, field][rows] = self.defaults[component][field]
        for key, array in values.items():
            if (column := layout.fields.get(key)) is not None:
                column[rows] = array
        return rows

    def settle(self, uid: np.ndarray, born: np.ndarray, values: Values, whole: bool = True) -> np.ndarray:
        """Add immigrants in the lowest free rows, with their uids u64[k] and ticks of birth i64[k]; return
        their rows. Unless `whole`, fields without values keep the row's previous content, which must not be
        read."""
        rows = self.occupy(uid.size, 0, 0, values, whole)
        self.uid[rows], self.born[rows] = uid, born
        return rows

    def doomed(self) -> np.ndarray:
        """Return the rows that have a cause of death, in ascending order: i64[k]."""
        return (self.cause[: self.high] != 0).nonzero()[0]

    def dying(self) -> np.ndarray:
        """Return the rows that have a cause of death, sorted by uid: i64[k]."""
        rows = self.doomed()
        return rows if rows.size < 2 else rows.take(self.uid.take(rows).argsort())

    def vacate(self, rows: np.ndarray) -> None:
        """Free the rows of dead entities."""
        self.version += 1
        self.high = vacate(rows, self.capacity, self.layout().rows, self.high)
        self.n -= rows.size
        if self.onlooker is not None:
            self.onlooker.stale = True

    def reorder(self, rows: np.ndarray) -> None:
        """Move each living entity from row `rows[i]` to row i; this changes no organism's future.

        Parameters
        ----------
        rows : array of int, shape (n,)
            The rows of all living entities, each once.

        Raises
        ------
        ValueError
            If `rows` does not contain exactly these rows.

        Notes
        -----
        If a system's objects keep data by row, they can have a `reorder(order)` method, which is also called:
        afterward, row i must contain the previous content of row `order[i]`.

        Examples
        --------
        >>> from ecs_eco import World
        >>> wolves = World.from_config("predator-prey", seed=1).table("wolf")
        >>> wolves.reorder(wolves.rows()[::-1])
        """
        rows = np.asarray(rows, np.int64)
        if not np.array_equal(np.sort(rows), self.rows()):
            raise ValueError(
                f"table {self.name!r}: reorder needs its {self.n} living rows, each once; "
                f"got {rows.size} that differ"
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
        Columns.replaced = object()  # even without columns, because row addresses have changed
        self.renew_handles()
        for part in self.parts().values():
            if callable(getattr(part, "reorder", None)):
                part.reorder(order)
        self.high = self.n
        self.version += 1

    @property
    def waiting(self) -> int:
        """Return the number of requested births that have not yet taken effect."""
        return sum(parents.size for parents, _, _ in self.births)

    def parts(self) -> dict[str, Any]:
        """Return, by name, the shared objects that can have state of their own."""
        return (self.species.parts() if self.species is not None else {}) | self.own

    @property
    def nbytes(self) -> int:
        """Return the size of all columns in bytes."""
        own = sum(array.nbytes for array in (*(getattr(self, a) for a in ROWS), *self.along.values()))
        return own + sum(a.nbytes for c in self.columns.values() for a in vars(c).values())


def _following(table: Callable[[], Table | None]) -> Callable[[], None]:
    """Snapshot the table's columns and derived components."""

    def follow() -> None:
        if (it := table()) is not None:
            dict.clear(it)
            dict.update(it, it.columns | it.derived)

    return follow


def _column(kind: Type, value: np.ndarray, capacity: int, living: np.ndarray) -> Any:
    """Return a new column with this default in every row; a heavy column stores the default only in living
    rows."""
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
