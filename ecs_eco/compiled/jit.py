"""The `njit` of this package: kept on disk, free of the GIL, and recompiled when any kernel's source changes."""

from collections.abc import Callable
from typing import Any

import numba

from ecs_eco.compiled import portable
from ecs_eco.compiled.kernel_folder import Folder, cache_folder
from ecs_eco.compiled.numba_version import plain

if plain():
    from ecs_eco.compiled.plain import c_function, kept_kernel
else:
    from ecs_eco.compiled.kernel import c_function, kept_kernel

portable.check()
if portable.on():
    numba.config.CPU_NAME, numba.config.CPU_FEATURES = portable.CPU, ""  # type: ignore[attr-defined]
FOLDER = Folder(cache_folder())
if portable.on():
    from ecs_eco.compiled.linking import install

    install(c_function, FOLDER)


def njit(function: Callable[..., Any], *, fastmath: bool | set[str] = False, noalias: bool = False) -> Any:
    """Compile a kernel on first use, keep it on disk, release the GIL while it runs,
    follow IEEE on division by 0.

    `noalias` promises that no array that the kernel writes overlaps another of its arrays. Loops that look
    numbers up at computed places become vector code only then.

    A parameter that is annotated with a named tuple takes one: see `ecs_eco.compiled.views`.

    A function without a source file, as one typed at a prompt, is compiled anew in each process. In the
    portable mode `fastmath` is not heeded: what it permits is done by some processors and not by others.
    """
    return kept_kernel(function, FOLDER, False if portable.on() else fastmath, noalias)


def lone_njit(function: Callable[..., Any]) -> Any:
    """`njit` with `noalias`: no array that the kernel writes overlaps another of its arrays."""
    return njit(function, noalias=True)
