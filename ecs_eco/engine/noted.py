"""Dicts that count changes to themselves: a value derived from such a dict is valid until the count changes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

K = TypeVar("K")
V = TypeVar("V")


class Noted(dict[K, V]):
    """A dict that increments `Noted.changes`, one counter for all such dicts in the process, with every change.

    A world's tables and a table's components are such dicts, so one number shows whether any of them has
    changed. Reading is as fast as in a plain dict. `follow` is called after each change.
    """

    changes = 0
    follow: Callable[[], Any] | None = None


def _noting(name: str) -> Callable[..., Any]:
    change = getattr(dict, name)

    def method(self: Noted[Any, Any], *arguments: object, **named: object) -> Any:
        Noted.changes += 1
        result = change(self, *arguments, **named)
        if self.follow is not None:
            self.follow()
        return result

    method.__name__, method.__doc__ = name, change.__doc__
    return method


for _name in ("__setitem__", "__delitem__", "__ior__", "clear", "pop", "popitem", "setdefault", "update"):
    setattr(Noted, _name, _noting(_name))
