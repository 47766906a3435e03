"""Hooks: lists of functions that are called when something happens."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def listening(hooks: list[Callable[..., Any]], call: Callable[..., Any]) -> Iterator[None]:
    """Append a function to a list of hooks within this context; afterwards it is removed,
    and the others stay."""
    hooks.append(call)
    try:
        yield
    finally:
        if call in hooks:
            hooks.remove(call)
