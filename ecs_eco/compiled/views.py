"""Views: named tuples that group related arrays and numbers into one argument of a kernel.

A kernel whose parameters are annotated as named tuples accesses their fields as in `space.torus` or
`mine.x[i]`. Passing a named tuple from Python takes one microsecond, plus another for every ten fields,
because numba also checks the names; many kernels take less time than that. The function for Python therefore
takes the fields one by one and builds the views from them, in code generated here from the annotations (see
benchmarks/kernel_arguments.py).
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from itertools import chain
from types import FunctionType
from typing import Any, TypeAlias

View: TypeAlias = type[Any]  # a named-tuple class
SEVERAL = inspect.CO_VARARGS | inspect.CO_VARKEYWORDS


def views_of(function: Callable[..., Any]) -> dict[str, View]:
    """Return the classes of parameters that are annotated as named tuples, by parameter name; there are none
    for a function with defaults or a variable number of arguments, which is passed to numba unchanged."""
    if (
        not isinstance(function, FunctionType)
        or function.__defaults__
        or function.__code__.co_flags & SEVERAL
    ):
        return {}
    notes = {
        name: function.__globals__.get(note) if isinstance(note, str) else note
        for name, note in function.__annotations__.items()
        if name != "return"
    }
    return {name: kind for name, kind in notes.items() if isinstance(kind, type) and hasattr(kind, "_fields")}


def taking_fields(
    function: FunctionType, views: dict[str, View], inner: Callable[..., Any]
) -> Callable[..., Any]:
    """Return the function that takes the fields of views and calls `inner`, which takes the views."""
    names = function.__code__.co_varnames[: function.__code__.co_argcount]
    fields = {name: [f"{name}__{one}" for one in kind._fields] for name, kind in views.items()}
    parameters = ", ".join(", ".join(fields.get(name, [name])) for name in names)
    made_of = ", ".join(f"view_{n}({', '.join(fields[n])})" if n in views else n for n in names)
    held = {"inner": inner, **{f"view_{name}": kind for name, kind in views.items()}}
    return _written(function, f"def {function.__name__}({parameters}):\n    return inner({made_of})", held)


def giving_fields(
    function: FunctionType, views: dict[str, View], fields: Callable[..., Any]
) -> Callable[..., Any]:
    """Return the function that takes views and calls `fields` with their fields."""
    names = function.__code__.co_varnames[: function.__code__.co_argcount]
    parts = {name: ", ".join(f"{name}__{one}" for one in kind._fields) for name, kind in views.items()}
    taken = "".join(
        f"    {part}, = {name}\n" for name, part in parts.items()
    )  # faster than *name in the call
    given = ", ".join(parts.get(name, name) for name in names)
    source = f"def {function.__name__}({', '.join(names)}):\n{taken}    return fields({given})"
    return _written(function, source, {"fields": fields})


def _written(function: FunctionType, source: str, held: dict[str, Any]) -> Callable[..., Any]:
    """Return a function compiled from generated source that replaces another one."""
    names: dict[str, Any] = {"__name__": function.__module__, **held}
    exec(compile(source, function.__code__.co_filename, "exec"), names)
    made: Callable[..., Any] = names[function.__name__]
    made.__qualname__, made.__doc__ = function.__qualname__, function.__doc__
    return made


def fields_of(arguments: Iterable[Any]) -> tuple[Any, ...]:
    """Return arguments with each view replaced by its fields."""
    fields = ((one if isinstance(one, tuple) and hasattr(one, "_fields") else (one,)) for one in arguments)
    return tuple(chain.from_iterable(fields))
