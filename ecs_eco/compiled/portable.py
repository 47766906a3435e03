"""The portable mode: identical bytes on every x86-64 machine, at some cost in speed.

It is off unless the environment variable ECS_ECO_PORTABLE is 1, or `enable` is called before numpy and numba
are loaded. It fixes the choices that compilers and libraries make according to the processor (see
`variables`). Where libraries offer no choice, it replaces them: elementary functions with
`ecs_eco.compiled.libm`, the initial orthogonal matrices of networks with `ecs_eco.learning.brain`.

This module imports nothing that loads numpy.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from ecs_eco.compiled.numba_version import interpreted

VARIABLE = "ECS_ECO_PORTABLE"
CPU = "x86-64-v2"
"""The processor that kernels are compiled for: the oldest that numpy supports (SSE 4.2, from 2008 on)."""

_LEVELS = "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"  # names of processor-specific code in numpy >= 2.4
_FEATURES = "SSE41 POPCNT SSE42 AVX F16C FMA3 AVX2 AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL " + (
    "AVX512_ICL AVX512_SPR"
)  # and in earlier versions
_LIBRARIES = {
    "MKL_CBWR": "COMPATIBLE",
    "ATEN_CPU_CAPABILITY": "default",
    "ONEDNN_MAX_CPU_ISA": "SSE41",
    "OPENBLAS_CORETYPE": "Nehalem",
}
_on = False


class PortableError(RuntimeError):
    """The portable mode cannot work in this process."""


def on() -> bool:
    """Return whether this process computes in the portable mode."""
    return _on


def mode() -> str:
    """Return "portable" or "native", as in manifests and checkpoints."""
    return "portable" if _on else "native"


def option() -> str:
    """Return the `ecs-eco` option that selects the mode of this process."""
    return " --portable" if _on else ""


def possible() -> bool:
    """Return whether this machine is x86-64."""
    return platform.machine().lower() in ("x86_64", "amd64")


def target() -> dict[str, str]:
    """Return the mode, and LLVM's name for the processor that kernels are compiled for."""
    if _on:
        return {"mode": mode(), "cpu": CPU}
    from ecs_eco.compiled.processor import processor  # it loads numba

    return {"mode": mode(), "cpu": processor()[1]}


def other_mode(noted: Mapping[str, Any]) -> str:
    """Return the error message for a manifest or checkpoint from the other mode, or "" if it is from this
    mode."""
    theirs = noted.get("target", {}).get("mode", "native")  # older files do not record a mode
    if theirs == mode():
        return ""
    how = (
        f"{VARIABLE}=1 or ecs-eco --portable"
        if theirs == "portable"
        else f"neither {VARIABLE} nor --portable"
    )
    return (
        f"was computed in the {theirs} mode, but this process is in the {mode()} mode, which gives different "
        f"bytes; continue in the other mode with {how}"
    )


def variables() -> dict[str, str]:
    """Return the environment variables of the portable mode, for job scripts on a cluster.

    ECS_ECO_PORTABLE=1 is enough if ecs_eco is imported before numpy, because it sets the other variables.
    """
    numpy = tuple(int(n) for n in version("numpy").split(".")[:2])
    return {
        VARIABLE: "1",
        "NUMBA_CPU_NAME": CPU,
        "NUMBA_CPU_FEATURES": "",
        "NUMBA_OPT": "3",
        "NUMBA_DISABLE_INTEL_SVML": "1",
        "NPY_DISABLE_CPU_FEATURES": _LEVELS if numpy >= (2, 4) else _FEATURES,
        **_LIBRARIES,
    }


def enable() -> None:
    """Switch this process and its children to the portable mode from now on. Raises PortableError on machines
    other than x86-64, and if numpy has already chosen its code.
    """
    global _on
    if not _on:
        os.environ.update(variables())
        _on = True
    check()


def begin() -> None:
    """Enable the mode if the environment variable requests it; `check` reports problems later."""
    global _on
    if os.environ.get(VARIABLE) == "1":
        os.environ.update(variables())
        _on = True


def check() -> None:
    """Raise PortableError if the environment variable is neither 0 nor 1, or if the mode is not possible
    here."""
    asked = os.environ.get(VARIABLE, "")
    if asked not in ("", "0", "1"):
        raise PortableError(
            f"{VARIABLE}={asked}: expected 1, for the same bytes on every x86-64 machine, or 0"
        )
    if not _on:
        return
    if not possible():
        raise PortableError(f"the portable mode requires x86-64, but this machine is {platform.machine()}")
    if interpreted():
        raise PortableError(
            "NUMBA_DISABLE_JIT: interpreted kernels compute with different precision; "
            "the portable mode needs compiled kernels"
        )
    if "numpy" in sys.modules and (others := _numpys_own()):
        raise PortableError(
            f"numpy was loaded before the portable mode, and uses {', '.join(others)}: "
            f"import ecs_eco first, with {VARIABLE}=1, or set NPY_DISABLE_CPU_FEATURES="
            f"'{variables()['NPY_DISABLE_CPU_FEATURES']}' too"
        )


def _numpys_own() -> list[str]:
    """Return the processor features that numpy uses beyond its minimum requirements."""
    try:
        from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
    except ImportError:  # these names are private and can change
        return []
    return [name for name in __cpu_dispatch__ if __cpu_features__.get(name)]
