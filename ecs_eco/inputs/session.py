"""The source code of functions and classes defined in an interactive session, such as a notebook."""

from __future__ import annotations

import ast
import dis
import inspect
import linecache
import sys
from collections.abc import Iterator
from types import CodeType
from typing import Any

CONSTANTS = (
    bool | int | float | complex | str | bytes | tuple | frozenset
)  # values that nothing changes in place


def is_interactive() -> bool:
    """Return whether `__main__` is interactive: it has no file, or IPython stores its cells as `In`."""
    main = sys.modules.get("__main__")
    return hasattr(main, "In") or getattr(main, "__file__", None) is None


def with_what_it_reads(name: str) -> str | None:
    """Return the current source of a function or class in `__main__` and of all functions, classes and
    constants of the session that it reads, directly or indirectly. Return None if it is not defined there."""
    if source_of(name) is None:
        return None
    found, waiting = {name: ""}, [name]
    for one in waiting:
        thing, source = _named(one), source_of(one)
        if source is not None:
            more = [read for read in _read_by(thing) if read not in found]
            found |= {one: source, **dict.fromkeys(more, "")}
            waiting += more
        elif isinstance(thing, CONSTANTS):
            found[one] = f"{one} = {thing!r}"
    return "\n".join(filter(None, found.values()))


def source_of(name: str) -> str | None:
    """Return the current source of a function or class in `__main__`, with its decorators, or else its
    bytecode. Return None if the name is not defined there."""
    thing = _named(name)
    if getattr(thing, "__module__", None) != "__main__" or not hasattr(thing, "__qualname__"):
        return None
    last = name.rpartition(".")[2]
    found = (source for text in _cells(thing) if (source := _definition(text, last)) is not None)
    return next(found, None) or repr(_compiled(thing))


def _named(name: str) -> Any:
    """Return an object in `__main__`, of a kernel its function, or None."""
    thing: Any = sys.modules.get("__main__")
    for part in name.split("."):
        thing = getattr(thing, part, None)
    return getattr(thing, "py_func", thing)


def _read_by(thing: Any) -> list[str]:
    """Return the names of the base classes of a class, and the global names that its functions read."""
    parts = [*vars(thing).values()] if inspect.isclass(thing) else [thing]
    functions = (getattr(part, "py_func", getattr(part, "__func__", part)) for part in parts)
    codes = [function.__code__ for function in functions if inspect.isfunction(function)]
    names = [base.__name__ for base in getattr(thing, "__bases__", ()) if base.__module__ == "__main__"]
    for code in codes:
        codes += [part for part in code.co_consts if isinstance(part, CodeType)]
        names += [step.argval for step in dis.get_instructions(code) if step.opname == "LOAD_GLOBAL"]
    return sorted(set(names))


def _cells(thing: object) -> Iterator[str]:
    """Yield the cells that define the object's functions, then all cells of the session, most recent first."""
    functions = [thing, *vars(thing).values()] if inspect.isclass(thing) else [thing]
    for file in dict.fromkeys(f.__code__.co_filename for f in functions if inspect.isfunction(f)):
        yield "".join(linecache.getlines(file))
    yield from reversed(getattr(sys.modules["__main__"], "In", ()))


def _definition(text: str, name: str) -> str | None:
    """Return the lines of the last definition of a name in source text, or None if the text does not define it."""
    try:
        nodes = [
            node
            for node in ast.walk(ast.parse(text))
            if isinstance(node, ast.ClassDef | ast.FunctionDef) and node.name == name
        ]
    except (SyntaxError, ValueError):
        return None
    if not nodes:
        return None
    first = min([nodes[-1].lineno, *(decorator.lineno for decorator in nodes[-1].decorator_list)])
    return "\n".join(text.splitlines()[first - 1 : nodes[-1].end_lineno])


def _compiled(thing: object) -> Any:
    """Return the contents of a function or class as numbers and strings that are the same in every session."""
    if inspect.isclass(thing):
        return [
            [name, _compiled(value)]
            for name, value in sorted(vars(thing).items())
            if name not in ("__dict__", "__weakref__", "__firstlineno__")
        ]
    if inspect.isfunction(thing):
        return [_compiled(thing.__code__), _compiled(thing.__defaults__)]
    if isinstance(thing, CodeType):
        return [thing.co_code, thing.co_names, _compiled(thing.co_consts)]
    if isinstance(thing, tuple | list):
        return [_compiled(part) for part in thing]
    if isinstance(thing, dict):
        return [[str(key), _compiled(value)] for key, value in thing.items()]
    return thing if isinstance(thing, str | bytes | int | float | complex | None) else type(thing).__name__
