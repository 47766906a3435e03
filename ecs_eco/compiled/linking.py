"""Link kernels to the functions of the portable mode instead of the C library's.

Kernels call `exp`, `cosf` and other functions by name, and LLVM looks up names here first. Kernels therefore
need no change, and their object code shows which functions they call (`ecs_eco.compiled.elf`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import llvmlite.binding as llvm
import numpy as np
from numba import carray, types

from ecs_eco.compiled import libm

if TYPE_CHECKING:
    from ecs_eco.compiled.kernel_folder import Folder
    from ecs_eco.compiled.numba_private import CPUDispatcher

NAMES = frozenset(f"{name}{kind}" for name in (*libm.ONE, *libm.TWO, "sincos") for kind in ("", "f"))
"""The C library names that are linked to functions of the portable mode."""
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
"""C library names whose results are the same everywhere, because they are exact or correctly rounded."""
_NUMPYS = {types.float64: np.float64, types.float32: np.float32}
_kept: list[Any] = []  # machine code of the linked functions


def install(c_function: Callable[..., Any], folder: Folder) -> None:
    """Permanently link the names to `libm` in this process.

    `c_function(function, signature, origin, folder, name)` compiles (see `ecs_eco.compiled.kernel`).
    """
    if _kept:
        return
    for kind, suffix in ((types.float64, ""), (types.float32, "f")):
        place = types.CPointer(kind)
        linked = [
            *((name, one, _of_one(one, kind), kind(kind)) for name, one in libm.ONE.items()),
            *((name, two, _of_two(two, kind), kind(kind, kind)) for name, two in libm.TWO.items()),
            ("sincos", libm.sin, _sincos(kind), types.void(kind, place, place)),
        ]
        for name, origin, function, signature in linked:
            compiled = c_function(function, signature, origin, folder, name + suffix)
            llvm.add_symbol(name + suffix, compiled.address)
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
