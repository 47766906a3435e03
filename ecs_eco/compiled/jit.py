"""The `njit` of this package: cached on disk, free of the GIL, and recompiled when any kernel's source
changes."""

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
    """Compile a kernel on first use, cache it on disk, release the GIL while it runs, follow IEEE on division
    by 0.

    `noalias` promises that no array that the kernel writes overlaps another of its arrays. Loops that read
    numbers at computed positions become vector code only with this promise.

    A parameter that is annotated with a named tuple takes one: see `ecs_eco.compiled.views`.

    A function without a source file, such as one typed at a prompt, is compiled again in each process. The
    portable mode ignores `fastmath`, which some processors use and others do not.
    """
    return kept_kernel(function, FOLDER, False if portable.on() else fastmath, noalias)


def lone_njit(function: Callable[..., Any]) -> Any:
    """Compile as `njit` does, with `noalias`: no array that the kernel writes overlaps another of its
    arrays."""
    return njit(function, noalias=True)
