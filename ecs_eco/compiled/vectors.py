"""Vectors of 16 float32 in kernels, which stay in registers where loops over arrays would access memory.

A loop whose accumulators are rows of an array loads and stores them in every step and checks whether rows
overlap. A `Vector`, in contrast, is a local variable, which you load, use in sums and products, and store.
LLVM maps it to one 512-bit register or to several narrower ones. Without compilation, vectors are numpy
arrays.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from llvmlite import ir
from llvmlite.binding import get_host_cpu_features
from numba import types
from numba.extending import intrinsic, lower_builtin, models, register_model, type_callable

from ecs_eco.compiled import portable
from ecs_eco.compiled.numba_version import interpreted

if TYPE_CHECKING:
    from ecs_eco.compiled.numba_private import (
        Context,
        CPUContext as CPUContext,
        DataModelManager,
        Signature as Signature,
    )

    Typing: TypeAlias = Context
    Emit: TypeAlias = Callable[[CPUContext, ir.IRBuilder, Signature, Sequence[ir.Value]], ir.Value]

LANES = 16
# whether a vector fits into one register and there are 32 of them; loops can then keep twice as many sums in
# registers
WIDE = not portable.on() and bool(get_host_cpu_features().get("avx512f", False))
_LLVM = ir.VectorType(ir.FloatType(), LANES)


class Vector(types.Type):
    """Numba's type for vectors of 16 float32."""

    def __init__(self) -> None:
        super().__init__("f32x16")


_vector = Vector()


@register_model(Vector)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: DataModelManager, of: types.Type) -> None:
        super().__init__(manager, of, _LLVM)  # type: ignore[no-untyped-call]


def place(
    context: CPUContext, builder: ir.IRBuilder, kind: types.Array, array: ir.Value, at: ir.Value
) -> ir.Value:
    """Return LLVM's address of array[at] for a one-dimensional array; `at` is not checked."""
    return builder.gep(context.make_array(kind)(context, builder, array).data, [at])


def _load(typing: Typing, array: types.Array, at: types.Type) -> tuple[Signature, Emit]:
    """Return array[at] … array[at + 15] of a contiguous f32 array as a vector; `at` is not checked."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        address = place(context, builder, signature.args[0], *arguments)
        vector = builder.load(builder.bitcast(address, _LLVM.as_pointer()))
        vector.align = 4
        return vector

    return _vector(array, types.intp), make


def _every(typing: Typing, array: types.Array, at: types.Type) -> tuple[Signature, Emit]:
    """Return a vector that repeats array[at] of a contiguous f32 array 16 times; `at` is not checked."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        number = builder.load(place(context, builder, signature.args[0], *arguments))
        return _repeated(builder, number)

    return _vector(array, types.intp), make


def _spread(typing: Typing, number: types.Type) -> tuple[Signature, Emit]:
    """Return a number, 16 times."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        return _repeated(builder, arguments[0])

    return _vector(types.float32), make


def _repeated(builder: ir.IRBuilder, number: ir.Value) -> ir.Value:
    nothing, first = ir.Constant(_LLVM, ir.Undefined), ir.Constant(ir.IntType(32), 0)
    return builder.shuffle_vector(
        builder.insert_element(nothing, number, first),
        nothing,
        ir.Constant(ir.VectorType(ir.IntType(32), LANES), None),
    )


def _where_less(
    typing: Typing, a: types.Type, b: types.Type, x: types.Type, y: types.Type
) -> tuple[Signature, Emit]:
    """Return x where a < b, and y elsewhere."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        a, b, x, y = arguments
        return builder.select(builder.fcmp_ordered("<", a, b), x, y)

    return _vector(_vector, _vector, _vector, _vector), make


def _floor(typing: Typing, vector: types.Type) -> tuple[Signature, Emit]:
    """Return the numbers rounded down to integers."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        kind = ir.FunctionType(_LLVM, [_LLVM])
        floor = builder.module.declare_intrinsic(f"llvm.floor.v{LANES}f32", fnty=kind)
        return builder.call(floor, arguments)

    return _vector(_vector), make


def _store(typing: Typing, array: types.Array, at: types.Type, vector: types.Type) -> tuple[Signature, Emit]:
    """Write a vector to array[at] … array[at + 15]; `at` is not checked."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        address = place(context, builder, signature.args[0], *arguments[:2])
        builder.store(arguments[2], builder.bitcast(address, _LLVM.as_pointer())).align = 4
        return context.get_dummy_value()

    return types.void(array, types.intp, _vector), make


def _prefetch(typing: Typing, array: types.Array, at: types.Type) -> tuple[Signature, Emit]:
    """Prefetch array[at]; any address is allowed."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        whole, byte = ir.IntType(32), ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [byte, whole, whole, whole])
        address = builder.bitcast(place(context, builder, signature.args[0], *arguments), byte)
        how = [ir.Constant(whole, 0), ir.Constant(whole, 3), ir.Constant(whole, 1)]
        builder.call(builder.module.declare_intrinsic("llvm.prefetch.p0i8", fnty=kind), [address, *how])
        return context.get_dummy_value()

    return types.void(array, types.intp), make


def _operator(of: Callable[[Any, Any], Any], name: str) -> None:
    """Implement an operator on two vectors, or on a vector and a float32, as the LLVM instruction with this
    name."""
    kinds = (_vector, _vector), (_vector, types.float32), (types.float32, _vector)

    @type_callable(of)
    def type_of(context: Typing) -> Callable[[types.Type, types.Type], types.Type | None]:
        return lambda a, b: _vector if (a, b) in kinds else None

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        a, b = (
            value if kind == _vector else _repeated(builder, value)
            for kind, value in zip(signature.args, arguments, strict=True)
        )
        return getattr(builder, name)(a, b)

    for kind in kinds:
        lower_builtin(of, *kind)(make)


if interpreted():

    def load(array: np.ndarray, at: int) -> np.ndarray:
        """Return array[at : at + 16], with zeros after the array's end."""
        there, out = array[at : at + LANES], np.zeros(LANES, array.dtype)
        out[: len(there)] = there
        return out

    def every(array: np.ndarray, at: int) -> np.ndarray:
        """Return an array that repeats array[at] 16 times."""
        return np.full(LANES, array[at])

    def spread(number: float | np.floating) -> np.ndarray:
        """Return a number, 16 times."""
        return np.full(LANES, number, np.float32)

    def where_less(a: np.ndarray, b: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return x where a < b, and y elsewhere."""
        return np.where(a < b, x, y)

    def floor(vector: np.ndarray) -> np.ndarray:
        """Return the numbers rounded down to integers."""
        return np.floor(vector)

    def store(array: np.ndarray, at: int, vector: np.ndarray) -> None:
        """Write a vector to array[at : at + 16]."""
        array[at : at + LANES] = vector

    def prefetch(array: np.ndarray, at: int) -> None:
        """Do nothing: prefetching exists only in compiled code."""

else:
    _intrinsic: Any = intrinsic  # numba annotates compilation, not calls
    load, every, spread, where_less, floor, store, prefetch = (
        _intrinsic(of) for of in (_load, _every, _spread, _where_less, _floor, _store, _prefetch)
    )
    _operator(operator.add, "fadd")
    _operator(operator.sub, "fsub")
    _operator(operator.mul, "fmul")
    _operator(operator.truediv, "fdiv")
