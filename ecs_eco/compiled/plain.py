"""Kernels compiled with numba's public API only: used instead of `kernel` if `numba_version.plain()` is true.

Results are bit-identical, but numba compiles functions twice if other kernels call them, stores compiled
forms in its own files, does not vectorize loops that `noalias` would permit, and counts references in each
call. Kernels are not divided into parts; instead, other threads take whole calls.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numba

from ecs_eco.compiled.numba_version import interpreted

if TYPE_CHECKING:
    from ecs_eco.compiled.kernel_folder import Folder
    from ecs_eco.compiled.numba_private import CPUDispatcher, Signature

_config: Any = numba.config  # its values are not annotated
_njit: Any = numba.njit  # these options are not annotated either
_cfunc: Any = numba.cfunc


def kept_kernel(
    function: Callable[..., Any], folder: Folder, fastmath: bool | set[str] = False, noalias: bool = False
) -> Any:
    """Return a function as a kernel whose compiled forms are cached in a folder; if numba is disabled, return
    the function itself."""
    keep = not interpreted() and os.path.isfile(function.__code__.co_filename) and folder.usable()
    with _keeps_in(folder):
        return _njit(nogil=True, error_model="numpy", fastmath=fastmath, cache=keep)(function)


def c_function(
    function: Callable[..., Any], signature: Signature, origin: CPUDispatcher, folder: Folder, name: str
) -> Any:
    """Return a function that C can call. It is compiled in each process, because numba does not cache
    functions defined within other functions."""
    return _cfunc(signature, nopython=True, nogil=True, error_model="numpy")(function)


@contextmanager
def _keeps_in(folder: Folder) -> Iterator[None]:
    """Make numba cache compiled functions in this folder within this context, without affecting other
    functions."""
    usual, _config.CACHE_DIR = _config.CACHE_DIR, str(folder.path)
    try:
        yield
    finally:
        _config.CACHE_DIR = usual
