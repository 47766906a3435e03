"""A kernel: compiled on first use, for Python and for other kernels apart.

What Python calls needs code that takes numbers out of Python's objects, and with thirty arrays that is most of
its code. What other kernels call needs none, so it is compiled by itself, without.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import Any

import numba
from numba import types
from numba.core.registry import CPUDispatcher


class Kernel(CPUDispatcher):  # type: ignore[misc]
    """numba's dispatcher for Python's calls; kernels that call this one get `inner`."""

    inner: Inner

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self.inner)  # type: ignore[no-untyped-call]

    def compile(self, sig: Any) -> Any:
        """Return the function for these types, found or compiled."""
        return _without_collections(super().compile, sig)


class Inner(CPUDispatcher):  # type: ignore[misc]
    """numba's dispatcher for calls from other kernels."""

    def compile(self, sig: Any) -> Any:
        """Return the function for these types, found or compiled."""
        return _without_collections(super().compile, sig)


def kernel(function: Callable[..., Any], **options: Any) -> Any:
    """Return a function as a kernel; as it is where numba is told to compile nothing (NUMBA_DISABLE_JIT)."""
    made = numba.njit(**options, no_cfunc_wrapper=True)(function)
    if isinstance(made, CPUDispatcher):
        made.__class__ = Kernel
        made.inner = numba.njit(**options, no_cfunc_wrapper=True, no_cpython_wrapper=True)(function)
        made.inner.__class__ = Inner
    return made


def _without_collections(compile_: Callable[[Any], Any], signature: Any) -> Any:
    """Compile while Python looks for no circles among the many objects that compiling makes and keeps."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        return compile_(signature)
    finally:
        if collecting:
            gc.enable()
