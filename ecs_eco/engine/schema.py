"""`@component` turns a class of annotated fields into a column layout and a handle type."""

import inspect
import sys
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias, TypeVar, cast, dataclass_transform

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from ecs_eco.engine.errors import unknown_name

C = TypeVar("C")


class Type:
    """The dtype, shape and limits of one organism's value in a column; tables resolve names in the shape."""

    __slots__ = ("blocked", "dtype", "limits", "shape")

    def __init__(
        self,
        dtype: DTypeLike,
        shape: tuple[int | str, ...] = (),
        blocked: bool = False,
        limits: tuple[float, float | str] | None = None,
    ) -> None:
        self.dtype = np.dtype(dtype)
        self.shape = shape
        self.blocked = blocked
        self.limits = limits

    @property
    def heavy(self) -> "Type":
        """Return the same type stored in blocks of rows, for values too large to copy when a table grows."""
        return Type(self.dtype, self.shape, True, self.limits)

    def within(self, low: float, high: float | str) -> "Type":
        """Return the same type with limits; values outside them are rejected when they enter a world.

        `high` can be a name, as in a shape.
        """
        return Type(self.dtype, self.shape, self.blocked, (low, high))

    def __getitem__(self, shape: int | str | tuple[int | str, ...]) -> "Type":
        return Type(self.dtype, shape if isinstance(shape, tuple) else (shape,), self.blocked, self.limits)

    def __call__(self, value: ArrayLike) -> Any:
        made: Any = self.dtype.type
        return made(value)

    def __repr__(self) -> str:
        inner = ", ".join(map(str, self.shape))
        return (f"{self.dtype.name}[{inner}]" if inner else self.dtype.name) + (
            ".heavy" if self.blocked else ""
        )

    def check(self, value: object, where: str) -> None:
        """Raise ValueError if a value has the wrong type, range or shape."""
        fixed = tuple(d for d in self.shape if not isinstance(d, str))
        try:
            array = np.asarray(value, self.dtype)
            if len(fixed) == len(self.shape):
                np.broadcast_to(array, fixed)
        except (TypeError, ValueError, OverflowError) as error:
            raise ValueError(f"{where}: {value!r} is not {self!r} ({error})") from None

    def resolve(self, dims: dict[str, int], where: str) -> tuple[int, ...]:
        """Return the shape with every name replaced by its size in `dims`."""
        unknown = [d for d in self.shape if isinstance(d, str) and d not in dims]
        if unknown:
            raise ValueError(
                f"{where}: the shape {self!r} needs the size {unknown[0]!r}; "
                f"declared: {sorted(dims) or 'none'}"
            )
        return tuple(dims[d] if isinstance(d, str) else d for d in self.shape)


if TYPE_CHECKING:  # what a handle returns
    f32: TypeAlias = float
    f64: TypeAlias = float
    i8: TypeAlias = int
    i16: TypeAlias = int
    i32: TypeAlias = int
    i64: TypeAlias = int
    u8: TypeAlias = int
    u16: TypeAlias = int
    u32: TypeAlias = int
    u64: TypeAlias = int
    boolean: TypeAlias = bool
else:
    f32, f64 = Type(np.float32), Type(np.float64)
    i8, i16, i32, i64 = Type(np.int8), Type(np.int16), Type(np.int32), Type(np.int64)
    u8, u16, u32, u64 = Type(np.uint8), Type(np.uint16), Type(np.uint32), Type(np.uint64)
    boolean = Type(np.bool_)


def column(kind: Any, *shape: int | str, within: tuple[float, float | str] | None = None) -> Any:
    """Return a column type with a shape and limits, for `Annotated`, which type checkers understand.

    Parameters
    ----------
    kind : column type
        For example `f32`.
    *shape : int or str
        Shape of one organism's value; names are sizes set by the table.
    within : tuple of float, optional
        Lowest and highest valid value. Other values are rejected when they enter a world.

    Returns
    -------
    column type

    Examples
    --------
    >>> from typing import Annotated
    >>> import numpy as np
    >>> from ecs_eco import column, component, f32, u8
    >>> @component
    ... class Fleece:
    ...     color: Annotated[u8, column(u8, within=(0, 9))] = 3
    ...     curl: Annotated[np.ndarray, column(f32, 3)] = np.zeros(3, np.float32)
    >>> Fleece(color=5)
    Fleece(color=5, curl=[0. 0. 0.])
    """
    made = kind[shape] if shape else kind
    return made if within is None else made.within(*within)


class Columns:
    """The arrays of one component in one table, one attribute per field: f32[capacity, …].

    `replaced` becomes a new object whenever an array in any table is replaced.
    """

    __slots__ = ("__dict__",)
    replaced: ClassVar[object] = object()

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    def __setattr__(self, name: str, value: ArrayLike) -> None:
        """Replace a column. Raises ValueError if the type, shape or layout differs or there are fewer rows,
        because kernels rely on these."""
        old = self.__dict__.get(name)
        if old is not None and value is not old:
            given = getattr(value, "dtype", type(value).__name__), getattr(value, "shape", ())
            if (
                given[0] != old.dtype
                or given[1][1:] != old.shape[1:]
                or not given[1]
                or given[1][0] < old.shape[0]
            ):
                raise ValueError(
                    f"column {name} is {old.dtype}{list(old.shape)} and cannot become "
                    f"{given[0]}{list(given[1])}; write into it: {name}[rows] = …"
                )
            if isinstance(value, np.ndarray) and not value.flags.c_contiguous:
                raise ValueError(
                    f"column {name} cannot become an array with gaps between its rows; "
                    f"write into it: {name}[rows] = …"
                )
        self.__dict__[name] = value
        Columns.replaced = object()  # last, so that earlier readers look again


class Handle:
    """One organism's component: its attributes read and write one row of the columns."""

    __slots__ = ("_columns", "_row")
    fields: dict[str, tuple[Type, Any]] = {}

    def __init__(self, **values: ArrayLike) -> None:
        unknown = [name for name in values if name not in self.fields]
        if unknown:
            raise TypeError(unknown_name(f"{type(self).__name__}", "field", unknown[0], self.fields))
        self._columns = Columns()
        self._row = 0
        for name, (kind, default) in self.fields.items():
            value = values.get(name, default)
            if name not in values and any(isinstance(d, str) for d in kind.shape):
                continue  # the table sets its size
            kind.check(value, f"{type(self).__name__}.{name}")
            array = np.asarray(value, kind.dtype)
            fixed = all(not isinstance(d, str) for d in kind.shape)
            setattr(
                self._columns,
                name,
                np.broadcast_to(array, kind.resolve({}, name))[None].copy() if fixed else array[None].copy(),
            )

    @classmethod
    def attach(cls, columns: Columns, row: int) -> "Handle":
        """Return a handle to one row, without copying."""
        handle = cls.__new__(cls)
        handle._columns = columns
        handle._row = row
        return handle

    def __repr__(self) -> str:
        values = ", ".join(
            f"{n}={getattr(self._columns, n)[self._row]}" for n in self.fields if hasattr(self._columns, n)
        )
        return f"{type(self).__name__}({values})"


def _accessor(name: str, scalar: bool) -> property:
    def read(self: Handle) -> Any:
        value = getattr(self._columns, name)[self._row]
        return value.item() if scalar else value

    def write(self: Handle, value: ArrayLike) -> None:
        getattr(self._columns, name)[self._row] = value

    return property(read, write)


@dataclass_transform(kw_only_default=True)
def component(cls: type[C]) -> type[C]:
    """Turn a class of annotated fields into a component: one column per field, and handles for single rows.

    Parameters
    ----------
    cls : type
        A class without bases. Each field has a default and is annotated with a column type (`f32`, `u64`,
        `f32[3]`, `f32["genes"]`), or with `Annotated` and `column`.

    Returns
    -------
    type
        The component, with the name, docstring and methods of the class.

    Raises
    ------
    TypeError
        If a field lacks a column type or default.
    ValueError
        If a default cannot be represented by its type.

    Examples
    --------
    >>> from ecs_eco import World, boolean, component, f32
    >>> @component
    ... class Wool:
    ...     length: f32 = 0.01  # [m]
    ...     shorn: boolean = False
    >>> world = World()
    >>> sheep = world.add_table("sheep", Wool)
    >>> world.spawn("sheep", Wool(length=0.5), n=2)
    >>> world.flush()
    >>> sheep[Wool].length[sheep.alive].tolist()
    [0.5, 0.5]
    """
    if cls.__bases__ != (object,):
        raise TypeError(
            f"{cls.__name__}: a component cannot inherit; list its fields instead of {cls.__bases__[0].__name__}"
        )
    fields: dict[str, tuple[Type, Any]] = {}
    for name, hint in _hints(cls).items():
        kind = next((mark for mark in getattr(hint, "__metadata__", ()) if isinstance(mark, Type)), hint)
        if not isinstance(kind, Type):
            raise TypeError(
                f"{cls.__name__}.{name}: {kind!r} is not a column type; use f32, f64, i32, i64, "
                "u8, u64, boolean, or f32[3]"
            )
        if name in ("fields", "attach") or name.startswith("_"):
            raise TypeError(f"{cls.__name__}.{name}: this name is reserved for handles; choose another")
        if name not in cls.__dict__:
            raise TypeError(f"{cls.__name__}.{name}: a field needs a default, as in `{name}: {kind!r} = 0`")
        fields[name] = (kind, cls.__dict__[name])
        kind.check(cls.__dict__[name], f"{cls.__name__}.{name}")
    if not fields:
        raise TypeError(f"{cls.__name__}: a component needs at least one field, as in `energy: f32 = 1.0`")
    body = {
        k: v
        for k, v in cls.__dict__.items()
        if k not in fields and k not in ("__dict__", "__weakref__", "__annotations__")
    }
    body |= {name: _accessor(name, not kind.shape) for name, (kind, _) in fields.items()}
    body |= {"__slots__": (), "fields": fields}
    return cast("type[C]", type(cls.__name__, (Handle,), body))


def _hints(cls: type) -> dict[str, Any]:
    """Return the annotations of a class; strings are evaluated in the module that defines the class."""
    scope = vars(sys.modules.get(cls.__module__, object())) if cls.__module__ in sys.modules else {}
    own = inspect.get_annotations(cls)
    return {n: eval(k, dict(scope)) if isinstance(k, str) else k for n, k in own.items()}  # noqa: S307
