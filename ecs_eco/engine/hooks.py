"""Hooks: lists of functions that are called when an event occurs."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def listening(hooks: list[Callable[..., Any]], call: Callable[..., Any]) -> Iterator[None]:
    """Append a function to a list of hooks within this context, and remove it afterward."""
    hooks.append(call)
    try:
        yield
    finally:
        if call in hooks:
            hooks.remove(call)
