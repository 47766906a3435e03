"""A compiled kernel as bytes, and back.

numba's own way back first loads all that it would need to compile, with it scipy's linear algebra, for half a
second. A kernel that is ready needs its machine code and the functions of numba's runtime that it calls.
"""

from __future__ import annotations

import sys
from functools import cache
from typing import TYPE_CHECKING, Any

import llvmlite.binding as llvm
from numba.core import serialize
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult, compile_result
from numba.core.environment import Environment, lookup_environment

from ecs_eco.compiled.elf import undefined
from ecs_eco.compiled.inner import Linked, stand_in

if TYPE_CHECKING:
    from numba.core.codegen import JITCPUCodegen
    from numba.core.cpu import CPUContext


def to_bytes(result: CompileResult) -> bytes:
    """Return a compiled form as bytes."""
    made: Any = result  # a named tuple, whose fields type checkers do not see
    library, description = made.library, made.fndesc
    library._ensure_finalized()
    code, bitcode, symbols = b"", b"", []
    if isinstance(library, Linked):
        bitcode = library._get_module_for_linking().as_bitcode()  # type: ignore[no-untyped-call]
    else:
        code, module = library._get_compiled_object(), library._final_module
        symbols = [
            symbol.name
            for group in (module.functions, module.global_variables)
            for symbol in group
            if not symbol.is_declaration
        ]
    called = ([] if not code else undefined(code)) if sys.platform == "linux" else None
    description.typemap = description.calltypes = None  # of no use, and not all of it can be written
    environments = made._find_referenced_environments()
    bare = [one.env_name for one in environments if _is_bare(one)]
    others = [one for one in environments if not _is_bare(one)]
    rest = (description, made.environment, made.signature, made.objectmode, made.lifted, made.reload_init)
    content = library.name, code, bitcode, symbols, called, rest, bare, others
    return bytes(serialize.dumps(content))


def from_bytes(content: bytes, target_context: CPUContext) -> CompileResult:
    """Return a compiled form, its machine code loaded; ModuleNotFoundError where its module is not there."""
    name, code, bitcode, symbols, called, rest, bare, others = serialize.loads(content)
    _provide_runtime()
    if called is None or not all(map(llvm.address_of_symbol, called)):
        target_context.refresh()  # numba's modules for compiling make known what machine code may call
    description, own, signature, objects, lifted, reload = rest
    for call in reload or ():
        call()
    codegen = target_context.codegen()
    environments = (*others, *map(_without_constants, bare))  # held, for machine code has their addresses
    if code:
        library: Any = _Library(codegen, name, code, symbols)
        function = target_context.get_executable(library, description, own)
        for one in environments:
            codegen.set_env(one.env_name, one)
    else:
        library = _Bitcode(codegen, name, bitcode)
        function = stand_in(description, own, library)
    return compile_result(
        target_context=target_context,
        typing_context=target_context.typing_context,
        library=library,
        environment=own,
        entry_point=function,
        fndesc=description,
        type_annotation="",
        signature=signature,
        objectmode=objects,
        lifted=lifted,
        reload_init=reload,
        referenced_envs=environments,
    )


class _Library(JITCodeLibrary):
    """Machine code that is there; what is linked into other kernels is `_Bitcode`."""

    def __init__(self, codegen: JITCPUCodegen, name: str, code: bytes, symbols: list[str]) -> None:
        super().__init__(codegen, name)  # type: ignore[no-untyped-call]
        self.enable_object_caching()  # type: ignore[no-untyped-call]
        self._set_compiled_object(code)  # type: ignore[no-untyped-call]
        self._finalize_final_module()  # type: ignore[no-untyped-call]
        codegen._engine._defined_symbols.update(symbols)


class _Bitcode(Linked):
    """Bitcode that is there; read when a kernel is compiled with it."""

    def __init__(self, codegen: JITCPUCodegen, name: str, bitcode: bytes) -> None:
        super().__init__(codegen, name)  # type: ignore[no-untyped-call]
        self._bitcode, self._finalized = bitcode, True

    def _get_module_for_linking(self) -> llvm.ModuleRef:
        if self._shared_module is None:
            self._shared_module = llvm.parse_bitcode(self._bitcode)
        return self._shared_module


@cache
def _provide_runtime() -> None:
    """Let machine code find the functions of numba's runtime, as `rtsys.initialize` does before it compiles
    others."""
    from numba.core.runtime import _nrt_python  # type: ignore[attr-defined]

    for name, address in _nrt_python.c_helpers.items():
        llvm.add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


def _is_bare(environment: Environment) -> bool:
    """Whether it is of a numba function without constants: nothing is read of it, so its module is not loaded."""
    return not environment.consts and environment.globals["__name__"].startswith("numba.")


def _without_constants(name: str) -> Environment:
    known = lookup_environment(name)
    if known is None:
        known = Environment({})
        known.env_name = name
    return known
