"""A kernel: compiled on first use, for Python and for other kernels apart.

What Python calls needs code that takes numbers out of Python's objects: with thirty arrays that is most of
it. What other kernels call needs none, so it is compiled by itself, without; and no machine code, see
`ecs_eco.compiled.inner`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numba
from numba import types
from numba.core.registry import CPUDispatcher

from ecs_eco.compiled.garbage import uncollected
from ecs_eco.compiled.inner import InnerPipeline, OuterPipeline
from ecs_eco.compiled.kernel_cache import KernelCache

if TYPE_CHECKING:
    from numba.core.cpu import CPUContext

    from ecs_eco.compiled.kernel_cache import Types


class Kernel(CPUDispatcher):
    """numba's dispatcher for Python's calls; kernels that call this one get `inner`."""

    inner: Any
    targetctx: CPUContext
    divided: Any = None  # it in parts (`ecs_eco.compiled.parts`)
    _cache: Any
    calls: ClassVar[list[tuple[Kernel, Types]]] = []
    """What Python has called in this process, in the order of first calls, with types."""

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self.inner)

    def compile(self, sig: Types) -> Any:
        """Return the function for these types, found or compiled."""
        cache = self._cache
        Kernel.calls.append((self, sig))
        with uncollected():
            if isinstance(cache, KernelCache) and cache.folder.shared:
                with cache.claimed(sig, self.targetctx):
                    return super().compile(sig)
            return super().compile(sig)

    def known(self, sig: Types) -> bool:
        """Return whether a compiled form for these types is kept, or another process makes it."""
        return isinstance(self._cache, KernelCache) and self._cache.known(sig, self.targetctx)


class Inner(CPUDispatcher):
    """numba's dispatcher for calls from other kernels."""

    _cache: Any

    def compile(self, sig: Types) -> Any:
        """Return the function for these types, found or compiled."""
        with uncollected():
            return super().compile(sig)


def kernel(function: Callable[..., Any], **options: Any) -> Any:
    """Return a function as a kernel; as it is where numba is told to compile nothing (NUMBA_DISABLE_JIT)."""
    njit: Any = numba.njit  # these options are not annotated
    options["no_cfunc_wrapper"] = True
    made: Any = njit(**options, pipeline_class=OuterPipeline)(function)
    if hasattr(made, "_cache"):
        made.__class__ = Kernel
        made.inner = njit(**options, no_cpython_wrapper=True, pipeline_class=InnerPipeline)(function)
        made.inner.__class__ = Inner
    return made
