"""The processor that numba compiles for, in LLVM's terms; an environment variable can select another one."""

from __future__ import annotations

from typing import Any

import llvmlite.binding as llvm
import numba

_config: Any = numba.config  # its values are not annotated


def processor() -> tuple[str, str, str]:
    """Return the triple, the name and the features in the form that numba passes to LLVM:
    "+sse2,-avx512f,…"."""
    name, features = _config.CPU_NAME, _config.CPU_FEATURES
    if name is None:
        name = llvm.get_host_cpu_name()
    return llvm.get_process_triple(), name, _host_features() if features is None else features


def _host_features() -> str:
    features = llvm.get_host_cpu_features()
    if not _config.ENABLE_AVX:
        features.update({one: False for one in features if one.startswith("avx")})
    return str(features.flatten())
