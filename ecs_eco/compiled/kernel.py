"""A kernel: compiled on first use, for Python and for other kernels apart.

What Python calls needs code that takes numbers out of Python's objects: with thirty arrays that is most of
it. What other kernels call needs none, so it is compiled by itself, without; and no machine code, see
`ecs_eco.compiled.inner`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import update_wrapper
from types import FunctionType
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numba
from numba import types
from numba.core.registry import CPUDispatcher

from ecs_eco.compiled.garbage import uncollected
from ecs_eco.compiled.inner import InnerPipeline, OuterPipeline
from ecs_eco.compiled.kernel_cache import KernelCache
from ecs_eco.compiled.views import giving_fields, taking_fields, views_of

if TYPE_CHECKING:
    from numba.core.cpu import CPUContext

    from ecs_eco.compiled.kernel_cache import Types
    from ecs_eco.compiled.views import View


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


class KernelOnViews:
    """A kernel that takes named tuples (`ecs_eco.compiled.views`): what Python calls is given their fields."""

    def __init__(self, function: FunctionType, views: dict[str, View], options: dict[str, Any]) -> None:
        update_wrapper(cast(Any, self), function)
        self.py_func, self.inner = function, _inner(function, options)
        self.on_fields: Kernel = kernel(taking_fields(function, views, self.inner), **options)

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self.inner)

    @property
    def signatures(self) -> list[Any]:
        """The types of fields that it was compiled for."""
        return list(self.on_fields.signatures)


def kernel(function: Callable[..., Any], **options: Any) -> Any:
    """Return a function as a kernel; as it is where numba is told to compile nothing (NUMBA_DISABLE_JIT)."""
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return function
    options["no_cfunc_wrapper"] = True
    if isinstance(function, FunctionType) and (views := views_of(function)):
        made = KernelOnViews(function, views, options)
        # a class of its own, for Python looks there for what calls it: one call less, of a quarter of a microsecond
        call = staticmethod(giving_fields(function, views, made.on_fields))
        made.__class__ = type("KernelOnViews", (KernelOnViews,), {"__call__": call})
        return made
    njit: Any = numba.njit  # these options are not annotated
    of_python: Any = njit(**options, pipeline_class=OuterPipeline)(function)
    of_python.__class__ = Kernel
    of_python.inner = _inner(function, options)
    return of_python


def _inner(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Return what other kernels call."""
    njit: Any = numba.njit
    made = njit(**options, no_cpython_wrapper=True, pipeline_class=InnerPipeline)(function)
    made.__class__ = Inner
    return made


def called_by_python(one: object) -> object:
    """Return the kernel that Python's calls of a kernel come to."""
    return one.on_fields if isinstance(one, KernelOnViews) else one
