"""Hooks: lists of functions that are called when something happens."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def listening(hooks: list[Callable[..., Any]], call: Callable[..., Any]) -> Iterator[None]:
    """Within it a function is in a list of hooks, at its end; afterwards it is not, and the others are as they were."""
    hooks.append(call)
    try:
        yield
    finally:
        if call in hooks:
            hooks.remove(call)
