"""The portable mode: the same bytes on every x86-64 machine, for some speed.

Off unless the variable ECS_ECO_PORTABLE is 1, or `enable` is called before numpy and numba are loaded. It
fixes what compilers and libraries would choose by the processor at hand: `variables` has these choices. What
libraries offer no choice of is replaced: elementary functions by `ecs_eco.compiled.libm`, the orthogonal
matrices that networks begin with by `ecs_eco.learning.orthogonal`.

Nothing is imported here that loads numpy.
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
"""What kernels are compiled for: numpy itself runs on no lesser processor (SSE 4.2, from 2008 on)."""

_LEVELS = "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"  # what numpy >= 2.4 calls its other code
_FEATURES = "SSE41 POPCNT SSE42 AVX F16C FMA3 AVX2 AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL " + (
    "AVX512_ICL AVX512_SPR"
)  # and earlier ones
_LIBRARIES = {
    "MKL_CBWR": "COMPATIBLE",
    "ATEN_CPU_CAPABILITY": "default",
    "ONEDNN_MAX_CPU_ISA": "SSE41",
    "OPENBLAS_CORETYPE": "Nehalem",
}
_on = False


class PortableError(RuntimeError):
    """Why the portable mode cannot be what it promises in this process."""


def on() -> bool:
    """Return whether this process computes in the portable mode."""
    return _on


def mode() -> str:
    """Return "portable" or "native", as manifests and checkpoints name it."""
    return "portable" if _on else "native"


def option() -> str:
    """Return what a command needs after `ecs-eco` to compute in the mode of this process."""
    return " --portable" if _on else ""


def possible() -> bool:
    """Return whether this machine is an x86-64 one."""
    return platform.machine().lower() in ("x86_64", "amd64")


def target() -> dict[str, str]:
    """Return the mode and the processor that kernels are compiled for, as LLVM calls it."""
    if _on:
        return {"mode": mode(), "cpu": CPU}
    from ecs_eco.compiled.processor import processor  # it loads numba

    return {"mode": mode(), "cpu": processor()[1]}


def other_mode(noted: Mapping[str, Any]) -> str:
    """Return what to say of a manifest or a checkpoint of the other mode; "" where it is of this one."""
    theirs = noted.get("target", {}).get("mode", "native")  # those of before have no word about it
    if theirs == mode():
        return ""
    how = (
        f"{VARIABLE}=1 or ecs-eco --portable"
        if theirs == "portable"
        else f"neither {VARIABLE} nor --portable"
    )
    return (
        f"was computed in the {theirs} mode, and this process is in the {mode()} one, which gives other "
        f"bytes; go on there, with {how}"
    )


def variables() -> dict[str, str]:
    """Return what the environment of a process in the portable mode holds: for scripts of a cluster's jobs.

    ECS_ECO_PORTABLE=1 alone does, where ecs_eco is imported before numpy: it sets the others.
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
    """Compute in the portable mode from here on, in this process and in those that it starts.

    Raises PortableError on other machines than x86-64, and where numpy has chosen its code already.
    """
    global _on
    if not _on:
        os.environ.update(variables())
        _on = True
    check()


def begin() -> None:
    """Enable the mode where the variable asks for it; `check` says later what is wrong."""
    global _on
    if os.environ.get(VARIABLE) == "1":
        os.environ.update(variables())
        _on = True


def check() -> None:
    """Raise PortableError where the variable says neither 0 nor 1, or where the mode cannot be had here."""
    asked = os.environ.get(VARIABLE, "")
    if asked not in ("", "0", "1"):
        raise PortableError(
            f"{VARIABLE}={asked}: allowed is 1, for the same bytes on every x86-64 machine, or 0"
        )
    if not _on:
        return
    if not possible():
        raise PortableError(f"the portable mode is for x86-64, and this machine is {platform.machine()}")
    if interpreted():
        raise PortableError(
            "NUMBA_DISABLE_JIT: interpreted kernels compute in another precision; "
            "the portable mode needs compiled ones"
        )
    if "numpy" in sys.modules and (others := _numpys_own()):
        raise PortableError(
            f"numpy was loaded before the portable mode, and uses {', '.join(others)}: "
            f"import ecs_eco first, with {VARIABLE}=1, or set NPY_DISABLE_CPU_FEATURES="
            f"'{variables()['NPY_DISABLE_CPU_FEATURES']}' too"
        )


def _numpys_own() -> list[str]:
    """Return what numpy uses of this processor beyond what it needs."""
    try:
        from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
    except ImportError:  # numpy keeps these names to itself, and may change them
        return []
    return [name for name in __cpu_dispatch__ if __cpu_features__.get(name)]
