"""Busy waiting without the GIL: poll a number in memory until another thread changes it."""

from __future__ import annotations

import platform
import time
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.vectors import place

if TYPE_CHECKING:
    from ecs_eco.compiled.vectors import CPUContext, Emit, Signature, Typing

X86 = platform.machine().lower() in ("x86_64", "amd64", "i386", "i686")


def _number(typing: Typing, numbers: types.Array, at: types.Type) -> tuple[Signature, Emit]:
    """Return the current value of numbers[at], an element of an array i64[n]."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        return builder.load_atomic(place(context, builder, signature.args[0], *arguments), "seq_cst", 8)

    return types.int64(numbers, types.intp), make


def _rest(typing: Typing) -> tuple[Signature, Emit]:
    """Pause this thread for a few cycles, so that a hyperthread can use the core."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        if X86:
            kind = ir.FunctionType(ir.VoidType(), [])
            builder.call(builder.module.declare_intrinsic("llvm.x86.sse2.pause", fnty=kind), [])
        return context.get_dummy_value()

    return types.none(), make


_intrinsic: Any = intrinsic  # numba annotates compilation, not calls
number, rest = _intrinsic(_number), _intrinsic(_rest)


@njit
def changes(counter, last, looks, rests):
    """Return whether an array of one i64 changes from `last` within `looks` checks; pause `rests` times after
    the change."""
    for _ in range(looks):
        if number(counter, 0) != last:
            for _ in range(rests):
                rest()
            return True
        rest()
    return False


@cache
def looks_of(seconds: float) -> int:
    """Return how many checks of a counter take this long; a single check takes 10 to 50 ns."""
    counter, took = np.zeros(1, np.int64), []
    changes(counter, 0, 1, 1)
    for _ in range(5):
        begin = time.perf_counter()
        changes(counter, 0, 2000, 1)
        took.append(time.perf_counter() - begin)
    return max(1, round(2000 * seconds / min(took)))
