"""The functions of the portable mode in the places of the C library's.

Kernels call `exp`, `cosf` and others by name; LLVM asks here first where a name leads. So a kernel needs no
word about it, and what it calls can be read off its object code (`ecs_eco.compiled.elf`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import llvmlite.binding as llvm
import numpy as np
from numba import carray, types
from numba.core.ccallback import CFunc

from ecs_eco.compiled import libm
from ecs_eco.compiled.kernel_cache import Folder, KernelCache

if TYPE_CHECKING:
    from numba.core.registry import CPUDispatcher
    from numba.core.typing import Signature

NAMES = frozenset(f"{name}{kind}" for name in (*libm.ONE, *libm.TWO, "sincos") for kind in ("", "f"))
"""The names of the C library that lead to functions of the portable mode."""
EXACT = frozenset(
    {
        "memcpy",
        "memset",
        "memmove",
        "fmod",
        "fmodf",
        "floor",
        "floorf",
        "ceil",
        "ceilf",
        "trunc",
        "truncf",
        "rint",
        "rintf",
        "sqrt",
        "sqrtf",
        "nearbyint",
        "nearbyintf",
        "round",
        "roundf",
        "fma",
        "fmaf",
        "ldexp",
        "ldexpf",
        "frexp",
        "frexpf",
    }
)
"""Names of the C library whose results are the same everywhere: they are exact, or correctly rounded."""
_NUMPYS = {types.float64: np.float64, types.float32: np.float32}
_kept: list[Any] = []  # machine code that names lead to


def install(folder: Folder) -> None:
    """Let the names lead to `libm`, in this process and for good; compiled forms are kept in the folder."""
    if _kept:
        return
    for kind, suffix in ((types.float64, ""), (types.float32, "f")):
        for name, function in libm.ONE.items():
            _link(name + suffix, function, _of_one(function, kind), kind(kind), folder)
        for name, function in libm.TWO.items():
            _link(name + suffix, function, _of_two(function, kind), kind(kind, kind), folder)
        place = types.CPointer(kind)
        _link("sincos" + suffix, libm.sin, _sincos(kind), types.void(kind, place, place), folder)


def _link(
    name: str, origin: CPUDispatcher, function: Callable[..., Any], signature: Signature, folder: Folder
) -> None:
    """Let a name lead to a function; `origin` is what it is made of, and stands for it in the cache, for the
    closure itself is another one in each process."""
    options = {"nopython": True, "nogil": True, "error_model": "numpy"}
    compiled: Any = CFunc(function, (signature.args, signature.return_type), {}, options)
    compiled._cache = KernelCache(origin.py_func, folder, name)
    compiled.compile()
    llvm.add_symbol(name, compiled.address)
    _kept.append(compiled)


def _of_one(function: CPUDispatcher, kind: types.Float) -> Callable[..., Any]:
    to = _NUMPYS[kind]

    def call(x):
        return to(function(np.float64(x)))

    return call


def _of_two(function: CPUDispatcher, kind: types.Float) -> Callable[..., Any]:
    to = _NUMPYS[kind]

    def call(x, y):
        return to(function(np.float64(x), np.float64(y)))

    return call


def _sincos(kind: types.Float) -> Callable[..., Any]:
    sin, cos, to = libm.sin, libm.cos, _NUMPYS[kind]

    def call(x, at_sin, at_cos):
        carray(at_sin, 1)[0] = to(sin(np.float64(x)))
        carray(at_cos, 1)[0] = to(cos(np.float64(x)))

    return call
