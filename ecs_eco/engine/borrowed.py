"""Kernels that borrow the arrays which Python hands them.

numba makes an owner of each array that comes from Python, and frees it after the call: of a kernel with
thirty arrays that is most of its fixed cost. Python's call keeps its arguments anyway while it lasts. So
arrays are only borrowed where the kernel cannot keep one for longer: where it returns none, and where there
is nothing that it could put one into.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core.callwrapper import PyCallWrapper
from numba.core.pythonapi import NativeValue, PythonAPI

_NUMBERS = (types.Number, types.Boolean, types.NoneType, types.Omitted)


class _Borrowing(PythonAPI):
    """numba's way to what Python's objects hold, in which nobody owns an array."""

    def nrt_adapt_ndarray_from_python(self, ary: Any, ptr: Any) -> Any:
        """Read where an array's numbers are, its shape and its strides."""
        kind = ir.FunctionType(ir.IntType(32), [self.pyobj, self.voidptr])
        read = self._get_function(kind, name="numba_adapt_ndarray")  # type: ignore[no-untyped-call]
        return self.builder.call(read, (ary, ptr))

    def to_native_value(self, typ: Any, obj: Any) -> NativeValue:
        """Return what an object holds."""
        native: NativeValue = super().to_native_value(typ, obj)  # type: ignore[no-untyped-call]
        if isinstance(typ, types.Array):  # a constant, so that the code that frees its owner falls away
            array = self.context.make_array(typ)(self.context, self.builder, native.value)
            array.meminfo = ir.Constant(array.meminfo.type, None)
            native.value = array._getvalue()
        return native


class _Wrapper(PyCallWrapper):
    def build_wrapper(self, api: Any, builder: Any, closure: Any, args: Any, kws: Any) -> None:
        borrowing = _Borrowing(self.context, builder)  # type: ignore[no-untyped-call]
        super().build_wrapper(borrowing, builder, closure, args, kws)  # type: ignore[no-untyped-call]


def wrap(context: Any, library: Any, description: Any, environment: Any, call_helper: Any,
         release_gil: bool) -> bool:
    """Make what Python calls, which borrows arrays; return False, with nothing done, for a kernel that could
    keep one."""
    if not (_holds(description.restype, *_NUMBERS)
            and all(_holds(kind, *_NUMBERS, types.Array) for kind in description.argtypes)):
        return False
    module = context.create_module("wrapper")
    kind = context.call_conv.get_function_type(description.restype, description.argtypes)
    function = ir.Function(module, kind, description.llvm_func_name)
    _Wrapper(context, module, function, description, environment, call_helper,  # type: ignore[no-untyped-call]
             release_gil).build()
    library.add_ir_module(module)
    return True


def _holds(kind: Any, *allowed: type) -> bool:
    """Return whether a type is one of those allowed, or a tuple of them."""
    parts: Any = kind  # numba's are not annotated
    if isinstance(kind, types.BaseTuple):
        return all(_holds(one, *allowed) for one in parts)
    return isinstance(kind, allowed)
