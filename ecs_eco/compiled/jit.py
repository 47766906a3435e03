"""The `njit` of this package: kept on disk, free of the GIL, and recompiled when any kernel's source changes."""

import os
from collections.abc import Callable
from typing import Any

import numba
from numba.core.cpu import CPUTargetOptions
from numba.core.options import TargetOptions

from ecs_eco.compiled import portable
from ecs_eco.compiled.kernel import Kernel, called_by_python, kernel
from ecs_eco.compiled.kernel_cache import Folder, KernelCache, cache_folder
from ecs_eco.compiled.views import views_of

numba.core.config._config_fname = ""  # no .numba_config.yaml of the folder that a command happens to run in
numba.config.reload_config()
# numba has the flag, and no option that sets it
CPUTargetOptions.noalias = TargetOptions.Mapping("noalias")
portable.check()
if portable.on():
    numba.config.CPU_NAME, numba.config.CPU_FEATURES = portable.CPU, ""  # type: ignore[attr-defined]
FOLDER = Folder(cache_folder())
if portable.on():
    from ecs_eco.compiled.linking import install

    install(FOLDER)


def njit(function: Callable[..., Any], *, fastmath: bool | set[str] = False, noalias: bool = False) -> Any:
    """Compile a kernel on first use, keep it on disk, release the GIL while it runs,
    follow IEEE on division by 0.

    `noalias` promises that no array that the kernel writes overlaps another of its arrays. Loops that look
    numbers up at computed places become vector code only then.

    A parameter that is annotated with a named tuple takes one: see `ecs_eco.compiled.views`.

    A function without a source file, as one typed at a prompt, is compiled anew in each process. In the
    portable mode `fastmath` is not heeded: what it permits is done by some processors and not by others.
    """
    fastmath = False if portable.on() else fastmath
    promises: dict[str, Any] = {"noalias": True} if noalias else {}
    made = kernel(function, nogil=True, error_model="numpy", fastmath=fastmath, **promises)
    called = called_by_python(made)
    # else nothing is compiled: NUMBA_DISABLE_JIT
    if isinstance(called, Kernel) and os.path.isfile(function.__code__.co_filename):
        options = str(sorted(fastmath) if isinstance(fastmath, set) else fastmath) + "noalias" * noalias
        fields = "".join(f" {name}{kind._fields}" for name, kind in views_of(function).items())
        called._cache = KernelCache(function, FOLDER, options + fields)
        called.inner._cache = KernelCache(function, FOLDER, f"{options}{fields} inner")
        made.inner._cache = KernelCache(function, FOLDER, f"{options} inner")
    return made


def lone_njit(function: Callable[..., Any]) -> Any:
    """`njit` with `noalias`: no array that the kernel writes overlaps another of its arrays."""
    return njit(function, noalias=True)
