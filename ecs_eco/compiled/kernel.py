"""Kernels: compiled when first called, separately for Python and for other kernels.

A function that Python calls needs code to unpack Python objects, which makes up most of its code if it takes
thirty arrays. A function that only kernels call needs neither this code nor machine code, so it is compiled
separately (see `ecs_eco.compiled.numba_private`). With `numba_version.plain()`, this file is not imported.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import update_wrapper
from types import FunctionType
from typing import TYPE_CHECKING, Any, ClassVar

import numba

from ecs_eco.compiled.garbage import uncollected
from ecs_eco.compiled.kernel_cache import KernelCache
from ecs_eco.compiled.numba_private import Dispatcher, InnerPipeline, OuterPipeline, compiled_for_c, prepare
from ecs_eco.compiled.views import giving_fields, taking_fields, views_of

if TYPE_CHECKING:
    from ecs_eco.compiled.kernel_cache import Types
    from ecs_eco.compiled.kernel_folder import Folder
    from ecs_eco.compiled.numba_private import CPUDispatcher, Signature
    from ecs_eco.compiled.views import View

prepare()


class Kernel(Dispatcher):
    """numba's dispatcher for calls from Python; kernels that call this one get `inner`."""

    divided: Any = None  # the kernel that runs it in parts (`ecs_eco.compiled.parts`)
    calls: ClassVar[list[tuple[Kernel, Types]]] = []
    """The kernels that Python has called in this process, with types, in the order of first calls."""

    def compile(self, sig: Types) -> Any:
        """Return the function for these types, cached or newly compiled."""
        cache = self.kept
        Kernel.calls.append((self, sig))
        with uncollected():
            if isinstance(cache, KernelCache) and cache.folder.shared:
                with cache.claimed(sig, self.targetctx):
                    return super().compile(sig)
            return super().compile(sig)

    def known(self, sig: Types) -> bool:
        """Return whether the cache has a compiled form for these types, or another process is compiling
        it."""
        return isinstance(self.kept, KernelCache) and self.kept.known(sig, self.targetctx)


class Inner(Dispatcher):
    """numba's dispatcher for calls from other kernels."""

    def compile(self, sig: Types) -> Any:
        """Return the function for these types, cached or newly compiled."""
        with uncollected():
            return super().compile(sig)


class KernelOnViews:
    """A kernel that takes named tuples (`ecs_eco.compiled.views`); the function for Python takes their
    fields."""

    def __init__(self, function: FunctionType, views: dict[str, View], options: dict[str, Any]) -> None:
        update_wrapper(self, function)  # type: ignore[arg-type]
        self.py_func, self.inner = function, _inner(function, options)
        self.on_fields: Kernel = kernel(taking_fields(function, views, self.inner), **options)

    @property
    def _numba_type_(self) -> Any:
        return numba.types.Dispatcher(self.inner)

    @property
    def signatures(self) -> list[Any]:
        """The field types that the kernel was compiled for."""
        return list(self.on_fields.signatures)


def kernel(function: Callable[..., Any], **options: Any) -> Any:
    """Return a function as a kernel."""
    options["no_cfunc_wrapper"] = True
    if isinstance(function, FunctionType) and (views := views_of(function)):
        made = KernelOnViews(function, views, options)
        # a separate class, because Python looks up calls on the class: this saves a quarter of a microsecond
        call = staticmethod(giving_fields(function, views, made.on_fields))
        made.__class__ = type("KernelOnViews", (KernelOnViews,), {"__call__": call})
        return made
    njit: Any = numba.njit  # these options are not annotated
    of_python: Any = njit(**options, pipeline_class=OuterPipeline)(function)
    of_python.__class__ = Kernel
    of_python.inner = _inner(function, options)
    return of_python


def _inner(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Return the function that other kernels call."""
    njit: Any = numba.njit
    made = njit(**options, no_cpython_wrapper=True, pipeline_class=InnerPipeline)(function)
    made.__class__ = Inner
    return made


def called_by_python(one: object) -> Any:
    """Return the kernel that runs when Python calls a kernel."""
    return one.on_fields if isinstance(one, KernelOnViews) else one


def kept_kernel(
    function: Callable[..., Any], folder: Folder, fastmath: bool | set[str] = False, noalias: bool = False
) -> Any:
    """Return a function as a kernel whose compiled forms are cached in a folder."""
    promises: dict[str, Any] = {"noalias": True} if noalias else {}
    made = kernel(function, nogil=True, error_model="numpy", fastmath=fastmath, **promises)
    called: Kernel = called_by_python(made)
    if os.path.isfile(function.__code__.co_filename):
        options = str(sorted(fastmath) if isinstance(fastmath, set) else fastmath) + "noalias" * noalias
        fields = "".join(f" {name}{kind._fields}" for name, kind in views_of(function).items())
        called.kept = KernelCache(function, folder, options + fields)
        called.inner.kept = KernelCache(function, folder, f"{options}{fields} inner")
        made.inner.kept = KernelCache(function, folder, f"{options} inner")
    return made


def c_function(
    function: Callable[..., Any], signature: Signature, origin: CPUDispatcher, folder: Folder, name: str
) -> Any:
    """Return a function that C can call. In the cache, it is identified by `name` and by `origin`, the kernel
    from which it is derived, because closures differ between processes."""
    return compiled_for_c(function, signature, KernelCache(origin.py_func, folder, name))
