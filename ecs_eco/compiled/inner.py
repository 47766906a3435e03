"""How kernels are compiled: machine code for those that Python calls, and for the others what is linked into
these.

numba makes machine code of each function by itself, also of one that only other kernels call: it is linked
into these, as bitcode, and compiled there once more. To leave that out saves a quarter of the first start.
"""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING, Any

from numba import _dynfunc, types  # type: ignore[attr-defined]
from numba.core import compiler_machinery
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.environment import lookup_environment
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering

if TYPE_CHECKING:
    from numba.core.compiler import StateDict
    from numba.core.environment import Environment
    from numba.core.funcdesc import FunctionDescriptor

_register: Any = compiler_machinery.register_pass  # numba's are not annotated
NUMBERS = types.Number, types.Boolean, types.NoneType, types.Omitted
ENVIRONMENT = "_ZN08NumbaEnv"  # how the names of variables begin that hold environments


class Linked(JITCodeLibrary):
    """A function as bitcode, to be linked with others; nothing of it is loaded."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._verify_declare_only_symbols()  # type: ignore[no-untyped-call]
        self._final_module.__library = weakref.proxy(self)
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: there is no machine code."""
        return 0


def stand_in(description: FunctionDescriptor, environment: Environment, library: Linked) -> Any:
    """Return a function that stands for one without machine code, and cannot be called."""
    name = description.qualname.split(".")[-1]
    return _dynfunc.make_function(description.lookup_module(), name, "", 0, environment, (library,))


@_register(mutates_CFG=True, analysis_only=False)
class InnerLowering(NativeLowering):
    """numba's lowering, without machine code."""

    _name = "inner_lowering"

    def run_pass(self, state: StateDict) -> bool:
        """Lower a function that is linked into others."""
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


class OuterLower(Lower):
    """numba's, whose kernels borrow the arrays that Python hands them.

    numba makes an owner of each array that comes from Python, and frees it after the call: of a kernel with
    thirty arrays that is most of its fixed cost. Python's call keeps its arguments anyway while it lasts. So
    they are borrowed where the kernel cannot keep one for longer: where it returns none, and where there is
    nothing that it could put one into.
    """

    def create_cpython_wrapper(self, release_gil: bool = False) -> None:
        """Make what Python calls."""
        about, context = self.fndesc, self.context
        if _holds(about.restype, *NUMBERS) and all(_holds(a, *NUMBERS, types.Array) for a in about.argtypes):
            context = context.subtarget(enable_nrt=False)  # who counts no references, owns nothing
        context.create_cpython_wrapper(
            self.library, about, self.env, self.call_helper, release_gil=release_gil
        )


def _holds(kind: types.Type, *allowed: type) -> bool:
    """Return whether a type is one of those allowed, or a tuple of them."""
    parts: Any = kind  # numba's are not annotated
    if isinstance(kind, types.BaseTuple):
        return all(_holds(one, *allowed) for one in parts)
    return isinstance(kind, allowed)


@_register(mutates_CFG=True, analysis_only=False)
class OuterLowering(NativeLowering):
    """numba's lowering, which then lets machine code find the environments of all functions in it."""

    _name = "outer_lowering"

    @property
    def lowering_class(self) -> type[Lower]:
        """What lowers a function that Python calls."""
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
    """numba's passes, with another one for lowering."""

    lowering: type[NativeLowering]

    def define_pipelines(self) -> list[Any]:
        """Return the only pipeline: kernels never fall back to Python's objects."""
        passes: Any = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.passes = [
            (self.lowering if one is NativeLowering else one, about) for one, about in passes.passes
        ]
        passes.finalize()
        return [passes]


class InnerPipeline(_Pipeline):
    """For functions that other kernels call."""

    lowering = InnerLowering


class OuterPipeline(_Pipeline):
    """For functions that Python calls."""

    lowering = OuterLowering
