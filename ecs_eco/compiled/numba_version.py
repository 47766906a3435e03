"""The choice of compiler: numba with `numba_private`, which changes numba's internals, or numba's public API
only.

The package is designed for the first option (`kernel`, `kernel_cache`, `parts`), which is tested with the
numba versions in `TRIED`. With any other version, or if ECS_ECO_PLAIN_NUMBA is 1, only the public API is used
(`plain`): results are the same, but kernels are slower. To try another version, see CONTRIBUTING.md, "Try a
new numba".
"""

from __future__ import annotations

import os
import warnings
from functools import cache
from importlib.metadata import version

TRIED = ("0.63", "0.64", "0.65", "0.66", "0.67", "0.68")
"""The minor versions that `numba_private` was tested with."""
VARIABLE = "ECS_ECO_PLAIN_NUMBA"


def interpreted() -> bool:
    """Return whether NUMBA_DISABLE_JIT turns off compilation."""
    return os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")


@cache
def plain() -> bool:
    """Return whether this process runs without `numba_private`; warn if the reason is an untested version.

    The variable ECS_ECO_PLAIN_NUMBA overrides the version: 1 for the public API only, 0 to try the installed
    version. Raises ValueError for any other value.
    """
    asked = os.environ.get(VARIABLE, "")
    if asked not in ("", "0", "1"):
        raise ValueError(f"{VARIABLE}={asked}: expected 1, for numba's public API only, or 0")
    if asked == "" and not interpreted() and not _is_tried():
        warnings.warn(
            f"numba {version('numba')} was not tested with this version of ecs_eco; {_tried()} were. Using "
            "numba's public API: results are the same, but kernels are slower. "
            f"Set {VARIABLE}=1 to silence this warning.",
            RuntimeWarning,
            stacklevel=2,
        )
    return asked == "1" or interpreted() or (asked == "" and not _is_tried())


def summary() -> str:
    """Return how kernels are compiled here and which versions were tested, for `ecs-eco doctor`."""
    how = "with numba's public API only, which is slower" if plain() else "with numba's private names"
    return f"compiled {how}; tested with {_tried()}"


def _is_tried() -> bool:
    return ".".join(version("numba").split(".")[:2]) in TRIED


def _tried() -> str:
    return f"numba {', '.join(TRIED)}"
