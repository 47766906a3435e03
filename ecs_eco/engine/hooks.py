"""Hooks: lists of functions that are called at an event."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def listening(hooks: list[Callable[..., Any]], call: Callable[..., Any]) -> Iterator[None]:
    """Append a function to a list of hooks within this context; remove only that function afterwards."""
    hooks.append(call)
    try:
        yield
    finally:
        if call in hooks:
            hooks.remove(call)
