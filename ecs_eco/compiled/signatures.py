"""Conversion of the types of a kernel's arguments to text and back."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numba

if TYPE_CHECKING:
    from numba import types as annotated

types: Any = numba.types  # not annotated throughout
_NUMBERS = types.Number, types.Boolean, types.NoneType, types.Omitted
_ARRAY = re.compile(r"(unaligned )?(readonly )?array\((\w+), (\d+)d, ([CFA])\)")
_SCALAR = re.compile(r"(?:u?int|float)(?:8|16|32|64)|bool|none")


def text(signature: tuple[Any, ...]) -> str:
    """Return the types of arguments as text, or "" if `read` could not recover them from it."""
    written = "; ".join(map(str, signature))
    try:
        return written if read(written) == signature else ""
    except ValueError:
        return ""


def read(written: str) -> tuple[Any, ...]:
    """Return the types of arguments from their text. Raises ValueError if it contains anything but numbers,
    arrays and tuples."""
    return tuple(_type(one) for one in written.split("; ")) if written else ()


def _type(written: str) -> Any:
    if _SCALAR.fullmatch(written):
        return {"bool": types.boolean}.get(written) or getattr(types, written)
    if match := _ARRAY.fullmatch(written):
        unaligned, readonly, of, axes, layout = match.groups()
        return types.Array(_type(of), int(axes), layout, readonly is not None, aligned=unaligned is None)
    if match := re.fullmatch(r"UniTuple\((.+) x (\d+)\)", written):
        return types.UniTuple(_type(match[1]), int(match[2]))
    if match := re.fullmatch(r"Tuple\((.+)\)", written):
        parts = re.split(r", (?![^()]*\))", match[1])
        return types.Tuple([_type(part) for part in parts])
    raise ValueError(f"{written!r} is not a number, an array or a tuple of them")


def borrows(result: annotated.Type, arguments: Iterable[annotated.Type]) -> bool:
    """Return whether a function of these types cannot keep an array, because it receives only arrays, numbers
    and tuples of them, and returns no array."""
    return _holds(result, *_NUMBERS) and all(_holds(one, *_NUMBERS, types.Array) for one in arguments)


def _holds(kind: annotated.Type, *allowed: type) -> bool:
    """Return whether a type is an allowed type, or a tuple of allowed types."""
    if isinstance(kind, types.BaseTuple):
        return all(_holds(one, *allowed) for one in kind)
    return isinstance(kind, allowed)
