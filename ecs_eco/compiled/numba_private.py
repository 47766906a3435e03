"""All of numba's private names that the package uses; any release of numba can change them.

`ecs_eco.compiled.numba_version` lists the versions that this module was tested with; with any other version,
`plain` is used instead. This module has three parts: the compilation of kernels, the conversion of compiled
kernels to bytes and back, and the base classes of `kernel` and `kernel_cache`.

Kernels that Python calls become machine code; all other kernels become bitcode that is linked into them.
Standard numba also generates machine code for functions that only other kernels call, and then compiles them
again as part of their callers. Skipping this makes the first start a quarter shorter.

To restore a kernel from bytes, standard numba first loads everything needed for compilation, including
scipy's linear algebra, which takes half a second. A finished kernel needs only its machine code and the
functions of numba's runtime that it calls.
"""

from __future__ import annotations

import sys
from functools import cache
from typing import TYPE_CHECKING, Any

import llvmlite.binding as llvm
import numba
from numba import _dynfunc, types  # type: ignore[attr-defined]
from numba.core import compiler_machinery, ir, serialize as serialize
from numba.core.caching import NullCache as NullCache
from numba.core.ccallback import CFunc
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import (
    CompilerBase,
    CompileResult as CompileResult,
    DefaultPassBuilder,
    compile_result,
)
from numba.core.cpu import CPUTargetOptions
from numba.core.environment import Environment, lookup_environment
from numba.core.lowering import Lower
from numba.core.options import TargetOptions
from numba.core.registry import CPUDispatcher as CPUDispatcher
from numba.core.runtime import _nrt_python  # type: ignore[attr-defined]
from numba.core.typed_passes import NativeLowering

from ecs_eco.compiled.elf import undefined
from ecs_eco.compiled.signatures import borrows

if TYPE_CHECKING:
    from collections.abc import Callable

    from numba.core.codegen import JITCPUCodegen as JITCPUCodegen
    from numba.core.compiler import StateDict
    from numba.core.cpu import CPUContext as CPUContext
    from numba.core.datamodel import DataModelManager as DataModelManager
    from numba.core.funcdesc import FunctionDescriptor
    from numba.core.typing import Context as Context, Signature as Signature

_register: Any = compiler_machinery.register_pass  # numba's decorators are not annotated
ENVIRONMENT = "_ZN08NumbaEnv"  # prefix of variables that contain environments


class Linked(JITCodeLibrary):
    """A function as bitcode, for linking with other functions; it is not loaded."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._verify_declare_only_symbols()  # type: ignore[no-untyped-call]
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: there is no machine code."""
        return 0


def stand_in(description: FunctionDescriptor, environment: Environment, library: Linked) -> Any:
    """Return a placeholder for a function without machine code, which cannot be called."""
    name = description.qualname.split(".")[-1]
    return _dynfunc.make_function(description.lookup_module(), name, "", 0, environment, (library,))


class _Borrowing(Lower):
    """numba's lowering for functions that borrow arrays from their callers.

    numba counts references to every array in a variable, although the caller keeps its arrays alive. Counting
    takes time and prevents loops that read arrays from named tuples from being vectorized. Here, references
    are counted only for arrays that a function creates or that another function returns.
    """

    def pre_lower(self) -> None:
        """Find the variables that contain borrowed arrays."""
        super().pre_lower()  # type: ignore[no-untyped-call]
        self.counting, self.borrowing = self.context, self.context.subtarget(enable_nrt=False)
        self.borrowed = _borrowed(self.blocks, self.fndesc.typemap, self.context.data_model_manager)

    def lower_inst(self, inst: ir.Stmt) -> None:
        """Lower one statement."""
        name = inst.target.name if isinstance(inst, ir.Assign) else getattr(inst, "value", None)
        self.context = self.borrowing if name in self.borrowed else self.counting
        super().lower_inst(inst)  # type: ignore[no-untyped-call]
        self.context = self.counting


def _borrowed(
    blocks: dict[int, ir.Block], kinds: dict[str, types.Type], models: DataModelManager
) -> set[str]:
    """Return the variables that contain only arrays of the caller and are not returned."""
    managed = {name for name, kind in kinds.items() if models[kind].contains_nrt_meminfo()}
    statements = [one for block in blocks.values() for one in block.body]
    assigned = [(one.target.name, one.value) for one in statements if isinstance(one, ir.Assign)]
    owned = managed & {one.value.name for one in statements if isinstance(one, ir.Return)}
    while True:
        own = {
            name for name, value in assigned if name in managed - owned and not _reads(value, kinds, owned)
        }
        if not own:
            return managed - owned
        owned |= own


def _reads(value: ir.Inst, kinds: dict[str, types.Type], owned: set[str]) -> bool:
    """Return whether a value is an argument, or a part or tuple of arrays that are not owned. This excludes
    parts of a list or object, which can drop them, and parts selected by an array, which are copies."""
    if not isinstance(value, ir.Expr):
        return isinstance(value, ir.Arg) or (isinstance(value, ir.Var) and value.name not in owned)
    if value.op == "call":
        reads = isinstance(kinds[value.func.name], types.NamedTupleClass)
    elif value.op in ("getattr", "getitem", "static_getitem", "exhaust_iter"):
        reads = isinstance(kinds[value.value.name], types.Array | types.BaseTuple) and (
            value.op != "getitem" or isinstance(kinds[value.index.name], types.Integer | types.SliceType)
        )
    else:
        reads = value.op in ("build_tuple", "cast", "phi")
    return reads and owned.isdisjoint(one.name for one in value.list_vars())


@_register(mutates_CFG=True, analysis_only=False)
class InnerLowering(NativeLowering):
    """numba's lowering without machine code."""

    _name = "inner_lowering"

    @property
    def lowering_class(self) -> type[Lower]:
        """The lowering of a function that other kernels call."""
        return _Borrowing

    def run_pass(self, state: StateDict) -> bool:
        """Lower a function that is linked into other functions."""
        codegen, name = state.targetctx.codegen(), state.func_id.func_qualname
        state.library = Linked(codegen, name)  # type: ignore[no-untyped-call]
        state.library.enable_object_caching()
        state.flags.no_compile = True
        super().run_pass(state)  # type: ignore[no-untyped-call]
        done, library = state["cr"], state.library
        function = stand_in(done.fndesc, done.env, library)
        state.targetctx.insert_user_function(function, done.fndesc, [library])
        state.reload_init.extend(library._reload_init)
        state["cr"] = done._replace(cfunc=function)
        return True


class OuterLower(_Borrowing):
    """numba's lowering for kernels that borrow the arrays that Python passes.

    numba takes a reference to each array from Python and releases it after the call. This is most of the
    fixed cost of a kernel with thirty arrays. The caller keeps its arguments alive during the call anyway.
    Arrays are therefore borrowed if the kernel cannot keep any for longer, because it returns no arrays and
    has nowhere to store one.
    """

    def create_cpython_wrapper(self, release_gil: bool = False) -> None:
        """Create the wrapper that Python calls."""
        about, context = self.fndesc, self.context
        if borrows(about.restype, about.argtypes):
            context = context.subtarget(enable_nrt=False)  # without reference counting, it owns nothing
        context.create_cpython_wrapper(
            self.library, about, self.env, self.call_helper, release_gil=release_gil
        )


@_register(mutates_CFG=True, analysis_only=False)
class OuterLowering(NativeLowering):
    """numba's lowering, which also links machine code to the environments of all functions in it."""

    _name = "outer_lowering"

    @property
    def lowering_class(self) -> type[Lower]:
        """The lowering of a function that Python calls."""
        return OuterLower

    def run_pass(self, state: StateDict) -> bool:
        """Lower a function that Python calls."""
        super().run_pass(state)  # type: ignore[no-untyped-call]
        for variable in state.library._final_module.global_variables:
            if variable.name.startswith(ENVIRONMENT):
                environment = lookup_environment(variable.name)
                if environment is not None:
                    state.targetctx.codegen().set_env(variable.name, environment)
        return True


class _Pipeline(CompilerBase):
    """numba's compiler passes with a different lowering."""

    lowering: type[NativeLowering]

    def define_pipelines(self) -> list[Any]:
        """Return the only pipeline: kernels never fall back to Python objects."""
        passes: Any = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.passes = [
            (self.lowering if one is NativeLowering else one, about) for one, about in passes.passes
        ]
        passes.finalize()
        return [passes]


class InnerPipeline(_Pipeline):
    """The pipeline for functions that other kernels call."""

    lowering = InnerLowering


class OuterPipeline(_Pipeline):
    """The pipeline for functions that Python calls."""

    lowering = OuterLowering


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
    description.typemap = description.calltypes = None  # unused and partly unpicklable
    environments = made._find_referenced_environments()
    bare = [one.env_name for one in environments if _is_bare(one)]
    others = [one for one in environments if not _is_bare(one)]
    rest = (description, made.environment, made.signature, made.objectmode, made.lifted, made.reload_init)
    content = library.name, code, bitcode, symbols, called, rest, bare, others
    return bytes(serialize.dumps(content))


def from_bytes(content: bytes, target_context: CPUContext) -> CompileResult:
    """Return a compiled form with its machine code loaded. Raises ModuleNotFoundError if its module does
    not exist."""
    name, code, bitcode, symbols, called, rest, bare, others = serialize.loads(content)
    _provide_runtime()
    if called is None or not all(map(llvm.address_of_symbol, called)):
        target_context.refresh()  # numba's compiler modules register the functions that machine code can call
    description, own, signature, objects, lifted, reload = rest
    for call in reload or ():
        call()
    codegen = target_context.codegen()
    environments = (
        *others,
        *map(_without_constants, bare),
    )  # kept alive, because machine code contains their addresses
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
    """Existing machine code; `_Bitcode` is code that is linked into other kernels."""

    def __init__(self, codegen: JITCPUCodegen, name: str, code: bytes, symbols: list[str]) -> None:
        super().__init__(codegen, name)  # type: ignore[no-untyped-call]
        self.enable_object_caching()  # type: ignore[no-untyped-call]
        self._set_compiled_object(code)  # type: ignore[no-untyped-call]
        self._finalize_final_module()  # type: ignore[no-untyped-call]
        codegen._engine._defined_symbols.update(symbols)


class _Bitcode(Linked):
    """Existing bitcode, which is read when a kernel is compiled with it."""

    def __init__(self, codegen: JITCPUCodegen, name: str, bitcode: bytes) -> None:
        super().__init__(codegen, name)  # type: ignore[no-untyped-call]
        self._bitcode, self._finalized = bitcode, True

    def _get_module_for_linking(self) -> llvm.ModuleRef:
        if self._shared_module is None:
            self._shared_module = llvm.parse_bitcode(self._bitcode)
        return self._shared_module


@cache
def _provide_runtime() -> None:
    """Link machine code to numba's runtime functions, as `rtsys.initialize` does before it compiles other
    functions."""
    for name, address in _nrt_python.c_helpers.items():
        llvm.add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


def _is_bare(environment: Environment) -> bool:
    """Return whether an environment belongs to a numba function without constants, whose module need not be
    loaded."""
    return not environment.consts and environment.globals["__name__"].startswith("numba.")


def _without_constants(name: str) -> Environment:
    known = lookup_environment(name)
    if known is None:
        known = Environment({})
        known.env_name = name
    return known


class Dispatcher(CPUDispatcher):
    """A dispatcher on argument types that uses our own cache; kernels that call it get `inner` if there is
    one."""

    inner: Any = None
    targetctx: CPUContext
    _cache: Any

    @property
    def kept(self) -> Any:
        """The cache of this function's compiled forms."""
        return self._cache

    @kept.setter
    def kept(self, cache: NullCache) -> None:
        self._cache = cache

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self if self.inner is None else self.inner)


def compiled_for_c(function: Callable[..., Any], signature: Signature, cache: NullCache) -> CFunc:
    """Return a function that C can call, either cached or newly compiled."""
    options = {"nopython": True, "nogil": True, "error_model": "numpy"}
    compiled: Any = CFunc(function, (signature.args, signature.return_type), {}, options)
    compiled._cache = cache
    compiled.compile()
    return compiled


def prepare() -> None:
    """Make numba ignore a .numba_config.yaml in the current folder, and give `njit` the `noalias` option:
    numba has this flag, but no option for it."""
    numba.core.config._config_fname = ""
    numba.config.reload_config()
    CPUTargetOptions.noalias = TargetOptions.Mapping("noalias")
