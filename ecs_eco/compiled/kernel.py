"""A kernel: compiled on first use, for Python and for other kernels apart.

What Python calls needs code that takes numbers out of Python's objects: with thirty arrays that is most of
it. What other kernels call needs none, so it is compiled by itself, without; and no machine code, see
`ecs_eco.compiled.numba_private`. Where `numba_version.plain()`, nothing imports this file.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numba

from ecs_eco.compiled.garbage import uncollected
from ecs_eco.compiled.kernel_cache import KernelCache
from ecs_eco.compiled.numba_private import Dispatcher, InnerPipeline, OuterPipeline, compiled_for_c, prepare

if TYPE_CHECKING:
    from ecs_eco.compiled.kernel_cache import Types
    from ecs_eco.compiled.kernel_folder import Folder
    from ecs_eco.compiled.numba_private import CPUDispatcher, Signature

prepare()


class Kernel(Dispatcher):
    """numba's dispatcher for Python's calls; kernels that call this one get `inner`."""

    divided: Any = None  # it in parts (`ecs_eco.compiled.parts`)
    calls: ClassVar[list[tuple[Kernel, Types]]] = []
    """What Python has called in this process, in the order of first calls, with types."""

    def compile(self, sig: Types) -> Any:
        """Return the function for these types, found or compiled."""
        cache = self.kept
        Kernel.calls.append((self, sig))
        with uncollected():
            if isinstance(cache, KernelCache) and cache.folder.shared:
                with cache.claimed(sig, self.targetctx):
                    return super().compile(sig)
            return super().compile(sig)

    def known(self, sig: Types) -> bool:
        """Return whether a compiled form for these types is kept, or another process makes it."""
        return isinstance(self.kept, KernelCache) and self.kept.known(sig, self.targetctx)


class Inner(Dispatcher):
    """numba's dispatcher for calls from other kernels."""

    def compile(self, sig: Types) -> Any:
        """Return the function for these types, found or compiled."""
        with uncollected():
            return super().compile(sig)


def kernel(function: Callable[..., Any], **options: Any) -> Any:
    """Return a function as a kernel."""
    njit: Any = numba.njit  # these options are not annotated
    options["no_cfunc_wrapper"] = True
    made: Any = njit(**options, pipeline_class=OuterPipeline)(function)
    made.__class__ = Kernel
    made.inner = njit(**options, no_cpython_wrapper=True, pipeline_class=InnerPipeline)(function)
    made.inner.__class__ = Inner
    return made


def kept_kernel(
    function: Callable[..., Any], folder: Folder, fastmath: bool | set[str] = False, noalias: bool = False
) -> Any:
    """Return a function as a kernel whose compiled forms are kept in a folder."""
    promises: dict[str, Any] = {"noalias": True} if noalias else {}
    made = kernel(function, nogil=True, error_model="numpy", fastmath=fastmath, **promises)
    if os.path.isfile(function.__code__.co_filename):
        options = str(sorted(fastmath) if isinstance(fastmath, set) else fastmath) + "noalias" * noalias
        made.kept = KernelCache(function, folder, options)
        made.inner.kept = KernelCache(function, folder, f"{options} inner")
    return made


def c_function(
    function: Callable[..., Any], signature: Signature, origin: CPUDispatcher, folder: Folder, name: str
) -> Any:
    """Return a function that C can call; the kernel `origin` is what it is made of, and stands for it in the
    folder under that name, for a closure is another one in each process."""
    return compiled_for_c(function, signature, KernelCache(origin.py_func, folder, name))
