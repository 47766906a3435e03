"""Vectors of 16 float32 within kernels, that stay in registers where a loop over an array would go to memory.

A loop whose accumulators are rows of an array loads and stores them in every step, and asks each time whether
rows overlap. A `Vector` is a local variable instead: load, add and multiply, store. LLVM makes of it what the
processor has: one register of 512 bits, or several narrower ones. Without compilation they are numpy arrays.
"""

import operator
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from llvmlite.binding import get_host_cpu_features
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.core.typing import templates as _templates
from numba.extending import intrinsic, lower_builtin, models, register_model

from ecs_eco.compiled import portable

LANES = 16
# Whether a vector is one register, of 32: loops may then keep twice as many sums in registers as elsewhere.
WIDE = not portable.on() and bool(get_host_cpu_features().get("avx512f", False))
_typing: Any = _templates  # numba's are not annotated
_lowered: Any = lower_builtin
_insert: Any = get_or_insert_function
_LLVM: Any = ir.VectorType(ir.FloatType(), LANES)


class Vector(types.Type):
    """Numba's type of 16 float32."""

    def __init__(self) -> None:
        super().__init__("f32x16")


_vector = Vector()


@register_model(Vector)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, of: Any) -> None:
        super().__init__(manager, of, _LLVM)  # type: ignore[no-untyped-call]


def place(context: Any, builder: Any, kind: Any, array: Any, at: Any) -> Any:
    """Return the address of array[at], as LLVM has it, for an array of one axis; `at` is not checked."""
    return builder.gep(context.make_array(kind)(context, builder, array).data, [at])


def _load(typing: Any, array: Any, at: Any) -> Any:
    """The numbers array[at] … array[at + 15] of a contiguous f32 array; `at` is not checked."""

    def make(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address = place(context, builder, signature.args[0], *arguments)
        vector = builder.load(builder.bitcast(address, _LLVM.as_pointer()))
        vector.align = 4
        return vector

    return _vector(array, types.intp), make


def _every(typing: Any, array: Any, at: Any) -> Any:
    """The number array[at] of a contiguous f32 array, 16 times; `at` is not checked."""

    def make(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = builder.load(place(context, builder, signature.args[0], *arguments))
        return _repeated(builder, number)

    return _vector(array, types.intp), make


def _spread(typing: Any, number: Any) -> Any:
    """A number, 16 times."""

    def make(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _repeated(builder, arguments[0])

    return _vector(types.float32), make


def _repeated(builder: Any, number: Any) -> Any:
    nothing, first = ir.Constant(_LLVM, ir.Undefined), ir.Constant(ir.IntType(32), 0)
    return builder.shuffle_vector(
        builder.insert_element(nothing, number, first),
        nothing,
        ir.Constant(ir.VectorType(ir.IntType(32), LANES), None),
    )


def _where_less(typing: Any, a: Any, b: Any, x: Any, y: Any) -> Any:
    """The numbers of x where a < b, else those of y."""

    def make(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        a, b, x, y = arguments
        return builder.select(builder.fcmp_ordered("<", a, b), x, y)

    return _vector(_vector, _vector, _vector, _vector), make


def _floor(typing: Any, vector: Any) -> Any:
    """The largest whole numbers that are no larger."""

    def make(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(_LLVM, [_LLVM])
        return builder.call(_insert(builder.module, kind, f"llvm.floor.v{LANES}f32"), arguments)

    return _vector(_vector), make


def _store(typing: Any, array: Any, at: Any, vector: Any) -> Any:
    """Write a vector to array[at] … array[at + 15]; `at` is not checked."""

    def make(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address = place(context, builder, signature.args[0], *arguments[:2])
        builder.store(arguments[2], builder.bitcast(address, _LLVM.as_pointer())).align = 4
        return context.get_dummy_value()

    return types.void(array, types.intp, _vector), make


def _prefetch(typing: Any, array: Any, at: Any) -> Any:
    """Let the processor begin to fetch what is at array[at], wherever that is: it never fails."""

    def make(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole, byte = ir.IntType(32), ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [byte, whole, whole, whole])
        address = builder.bitcast(place(context, builder, signature.args[0], *arguments), byte)
        how = [ir.Constant(whole, 0), ir.Constant(whole, 3), ir.Constant(whole, 1)]
        builder.call(_insert(builder.module, kind, "llvm.prefetch.p0i8"), [address, *how])
        return context.get_dummy_value()

    return types.void(array, types.intp), make


def _operator(of: Callable[[Any, Any], Any], name: str) -> None:
    """Let an operator of two vectors, or of a vector and a float32, be LLVM's instruction of this name."""
    kinds = (_vector, _vector), (_vector, types.float32), (types.float32, _vector)

    @_typing.infer_global(of)
    class Typing(_typing.AbstractTemplate):  # type: ignore[misc]
        key = of

        def generic(self, args: Any, kws: Any) -> Any:
            return _typing.signature(_vector, *args) if args in kinds else None

    def make(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        a, b = (
            value if kind == _vector else _repeated(builder, value)
            for kind, value in zip(signature.args, arguments, strict=True)
        )
        return getattr(builder, name)(a, b)

    for kind in kinds:
        _lowered(of, *kind)(make)


if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]

    def load(array: np.ndarray, at: int) -> np.ndarray:
        """Return array[at : at + 16]; zeros behind the array's end."""
        there, out = array[at : at + LANES], np.zeros(LANES, array.dtype)
        out[: len(there)] = there
        return out

    def every(array: np.ndarray, at: int) -> np.ndarray:
        """Return array[at], 16 times."""
        return np.full(LANES, array[at])

    def spread(number: Any) -> np.ndarray:
        """Return a number, 16 times."""
        return np.full(LANES, number, np.float32)

    def where_less(a: np.ndarray, b: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the numbers of x where a < b, else those of y."""
        return np.where(a < b, x, y)

    def floor(vector: np.ndarray) -> np.ndarray:
        """Return the largest whole numbers that are no larger."""
        return np.floor(vector)

    def store(array: np.ndarray, at: int, vector: np.ndarray) -> None:
        """Write a vector to array[at : at + 16]."""
        array[at : at + LANES] = vector

    def prefetch(array: np.ndarray, at: int) -> None:
        """Do nothing: for what is compiled alone."""

else:
    _made: Any = intrinsic
    load, every, spread, where_less, floor, store, prefetch = (
        _made(of) for of in (_load, _every, _spread, _where_less, _floor, _store, _prefetch)
    )
    _operator(operator.add, "fadd")
    _operator(operator.sub, "fsub")
    _operator(operator.mul, "fmul")
    _operator(operator.truediv, "fdiv")
