"""The package's kernels, and the kernels that have run in this process."""

from __future__ import annotations

import importlib
from functools import cache
from pathlib import Path
from typing import Any

import ecs_eco

OWN = (
    "jit.py",
    "kernel_folder.py",
    "__init__.py",
    "__main__.py",
)  # these modules mention njit but have no kernels


@cache
def kernels() -> dict[str, Any]:
    """Return all compiled functions in the package, by module and name."""
    from numba.core.dispatcher import Dispatcher

    from ecs_eco.compiled.kernel import KernelOnViews

    root, dispatchers = Path(ecs_eco.__file__).parent, {}
    for path in sorted(root.rglob("*.py")):
        if "njit" in path.read_text(encoding="utf-8") and path.name not in OWN:
            name = ".".join(path.relative_to(root).with_suffix("").parts)
            held = vars(importlib.import_module(f"ecs_eco.{name}"))
            dispatchers |= {
                f"{name}.{word}": one
                for word, one in held.items()
                if isinstance(one, Dispatcher | KernelOnViews) and one.__module__ == f"ecs_eco.{name}"
            }
    return dispatchers


def reached() -> set[str]:
    """Return the kernels that were called and the kernels that they call; a kernel loaded from the disk
    cache includes its callees."""
    called = [one for one in kernels().values() if one.signatures]
    names, seen = {id(one): name for name, one in kernels().items()}, set()
    while called:
        one = called.pop()
        if id(one) in names and names[id(one)] not in seen:
            seen.add(names[id(one)])
            held = one.py_func.__globals__
            called += [
                held[word] for word in one.py_func.__code__.co_names if hasattr(held.get(word), "py_func")
            ]
    return seen
