"""What compiles kernels here: numba with `numba_private`, which changes its inside, or public numba alone.

The first is what this package is built for: `kernel`, `kernel_cache`, `parts`. It holds for the versions of
numba that it was tried with. With another one, and where ECS_ECO_PLAIN_NUMBA is 1, public numba compiles
(`plain`): slower, with the same results. To try another version: CONTRIBUTING.md, "Try a new numba".
"""

from __future__ import annotations

import os
import warnings
from functools import cache
from importlib.metadata import version

TRIED = ("0.63", "0.64", "0.65", "0.66", "0.67", "0.68")
"""The minor versions that `numba_private` was tried with."""
VARIABLE = "ECS_ECO_PLAIN_NUMBA"


def interpreted() -> bool:
    """Return whether numba compiles nothing: NUMBA_DISABLE_JIT."""
    return os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")


@cache
def plain() -> bool:
    """Return whether this process does without `numba_private`; warns where that is for an untried version.

    The variable ECS_ECO_PLAIN_NUMBA overrides the version: 1 for public numba alone, 0 to try the version
    that is there. Raises ValueError where it says something else.
    """
    asked = os.environ.get(VARIABLE, "")
    if asked not in ("", "0", "1"):
        raise ValueError(f"{VARIABLE}={asked}: allowed is 1, for public numba alone, or 0")
    if asked == "" and not interpreted() and not _is_tried():
        warnings.warn(
            f"numba {version('numba')} was not tried with this version of ecs_eco; {_tried()} were. Public numba "
            f"alone compiles kernels: the same results, more slowly. {VARIABLE}=1 does so without this warning.",
            RuntimeWarning,
            stacklevel=2,
        )
    return asked == "1" or interpreted() or (asked == "" and not _is_tried())


def summary() -> str:
    """Return what compiles kernels here, and which versions were tried, as `ecs-eco doctor` says it."""
    how = "by public numba alone, which is slower" if plain() else "with private names of numba"
    return f"compiled {how}; tried with {_tried()}"


def _is_tried() -> bool:
    return ".".join(version("numba").split(".")[:2]) in TRIED


def _tried() -> str:
    return f"numba {', '.join(TRIED)}"
