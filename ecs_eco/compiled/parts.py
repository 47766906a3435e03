"""A kernel's range divided into parts, which the threads of a world take one after another without the GIL:
fork and join with dynamic scheduling, as in OpenMP.

Passing a call to another thread through Python takes at least 25 µs, and 100 µs if one of the two then waits
for the GIL, which is as long as many of the tasks in a tick. The calling thread therefore writes its
arguments, in the kernel's format, to a buffer that the helpers read, with the address of code that calls the
kernel with them. A job is open while its number is odd. A helper registers as active, then checks again
whether the job is still open; the thread that closes the job waits until no helper is active. A helper can
therefore arrive late or not at all; the other threads then do its parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.kernel import Kernel, KernelOnViews, kernel
from ecs_eco.compiled.kernel_cache import KernelCache
from ecs_eco.compiled.spinning import number, rest
from ecs_eco.compiled.vectors import place

if TYPE_CHECKING:
    from ecs_eco.compiled.vectors import CPUContext, Emit, Signature, Typing

# positions in a team's record, i64[RECORD]; positions written by several threads are 64 bytes apart
JOB, NEXT, INSIDE = 0, 8, 16  # the job's number; the next part; the number of active helpers
PARTS, FIRST, LAST, CODE, ARGUMENTS, FAILED = range(24, 30)
RECORD = 32
ROOM = 1 << 16  # [bytes] size of the buffer for the arguments of one call
_I64 = ir.IntType(64)
_BYTE = ir.IntType(8).as_pointer()
_PART = ir.FunctionType(_I64, [_I64, _I64, _BYTE])  # (first, last, arguments) → 0 or an error code


def _add(typing: Typing, record: types.Array, at: types.Type, more: types.Type) -> tuple[Signature, Emit]:
    """Add to record[at] atomically; return the previous value."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        address = place(context, builder, signature.args[0], *arguments[:2])
        return builder.atomic_rmw("add", address, arguments[2], "seq_cst")

    return types.int64(record, types.intp, types.int64), make


def _call(
    typing: Typing, code: types.Type, first: types.Type, last: types.Type, held: types.Type
) -> tuple[Signature, Emit]:
    """Call the code at an address for first … last − 1, with arguments at another address."""

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, arguments: Sequence[ir.Value]
    ) -> ir.Value:
        code, first, last, held = arguments
        return builder.call(
            builder.inttoptr(code, _PART.as_pointer()), [first, last, builder.inttoptr(held, _BYTE)]
        )

    return types.int64(types.int64, types.int64, types.int64, types.int64), make


def _lay_out(
    typing: Typing, of: types.Dispatcher, room: types.Array, arguments: types.Tuple | types.UniTuple
) -> tuple[Signature, Emit]:
    """Write arguments to the buffer, and return the address of code that calls the kernel `of` with them."""
    call: Any = of.get_call_type(typing, (types.intp, types.intp, *arguments.types), {})
    kernel: Any = of.dispatcher

    def make(
        context: CPUContext, builder: ir.IRBuilder, signature: Signature, given: Sequence[ir.Value]
    ) -> ir.Value:
        kind = given[2].type
        if context.get_abi_sizeof(kind) > ROOM:
            raise ValueError(
                f"kernel {kernel.__name__}: its arguments take "
                f"{context.get_abi_sizeof(kind)} bytes; at most {ROOM} can be divided"
            )
        compiled = kernel.overloads[call.args]
        context.active_code_library.add_linking_library(compiled.library)
        part = ir.Function(builder.module, _PART, f"{builder.function.name}.part")
        part.linkage = "internal"
        inside = ir.IRBuilder(part.append_basic_block())
        held = inside.load(inside.bitcast(part.args[2], kind.as_pointer()))
        about = compiled.fndesc
        status, value = context.call_conv.call_function(
            inside,
            context.declare_function(builder.module, about),
            about.restype,
            about.argtypes,
            [*part.args[:2], *(inside.extract_value(held, i) for i in range(len(arguments.types)))],
        )
        if context.enable_nrt:  # the result is not used
            context.nrt.decref(inside, about.restype, value)
        inside.ret(inside.zext(status.is_error, _I64))
        begin = context.make_array(signature.args[1])(context, builder, given[1]).data
        builder.store(given[2], builder.bitcast(begin, kind.as_pointer()))
        return builder.ptrtoint(part, _I64)

    return types.int64(of, room, arguments), make


_intrinsic: Any = intrinsic  # numba annotates compilation, not calls
add, call, lay_out = _intrinsic(_add), _intrinsic(_call), _intrinsic(_lay_out)


@njit
def take_parts(record):
    """Do the parts of a job that no thread has taken yet."""
    parts, first, n = record[PARTS], record[FIRST], record[LAST] - record[FIRST]
    k = add(record, NEXT, 1)
    while k < parts:
        if call(record[CODE], first + n * k // parts, first + n * (k + 1) // parts, record[ARGUMENTS]):
            record[FAILED] = 1
        k = add(record, NEXT, 1)


@njit
def alone(record, looks):
    """Return whether all helpers are inactive, or become inactive within `looks` checks."""
    for _ in range(looks):
        if number(record, INSIDE) == 0:
            return True
        rest()
    return False


@njit
def serve(record, asked, last, looks, rests):
    """Take parts of all open jobs. Return whether `asked` changes from `last` within `looks` checks after the
    last job; after a change, pause `rests` times."""
    left, done = looks, 0
    while left > 0:
        job = number(record, JOB)
        if job & 1 and job != done:
            add(record, INSIDE, 1)
            if number(record, JOB) == job:
                take_parts(record)
                left = looks
            add(record, INSIDE, -1)
            done = job
        if number(asked, 0) != last:
            for _ in range(rests):
                rest()
            return True
        rest()
        left -= 1
    return False


def divided(one: Kernel) -> Kernel:
    """Return a kernel that runs a kernel of (first, last, *arguments) in parts shared with other threads. It
    takes (record, buffer, address of the buffer, first, last, parts, checks, *arguments) and returns whether
    everything is done after this many checks; if not, call `alone` until it is."""
    if one.divided is not None:
        return one.divided
    inner = one.inner

    def run(record, room, address, first, last, parts, looks, *arguments):
        record[CODE], record[ARGUMENTS] = lay_out(inner, room, arguments), address
        record[PARTS], record[FIRST], record[LAST], record[NEXT], record[FAILED] = parts, first, last, 0, 0
        add(record, JOB, 1)
        take_parts(record)
        add(record, JOB, 1)
        return alone(record, looks)

    made = kernel(run, nogil=True, error_model="numpy")
    if isinstance(one.kept, KernelCache):
        made.kept = KernelCache(one.py_func, one.kept.folder, f"{one.kept.options} in parts")
    one.divided = made
    return made


def can_be_divided(one: object) -> TypeGuard[Kernel | KernelOnViews]:
    """Return whether an object is one of our kernels and has no default arguments."""
    return isinstance(one, Kernel | KernelOnViews) and not one.py_func.__defaults__


def record_of_a_team() -> np.ndarray:
    """Return the record, i64[RECORD], aligned to a cache line."""
    held = np.zeros(RECORD + 8, np.int64)
    first = -held.ctypes.data // 8 % 8
    return held[first : first + RECORD]
