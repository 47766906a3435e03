"""Versions of software that affects results."""

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version

PACKAGES = ("ecs-eco", "esper", "numpy", "numba", "torch", "pyarrow")


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that affect results."""
    return {"python": platform.python_version()} | {name: _installed(name) for name in PACKAGES}


@cache
def _installed(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
