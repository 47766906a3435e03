"""The `njit` of this package: cached, free of the GIL, and recompiled when any kernel's source changes.

numba's cache does not notice a change in a function that lives in another file, so the cache folder is named after a
hash of the package's sources.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba

_ROOT = Path(__file__).parent


def _sources_hash() -> str:
    digest = hashlib.sha256(numba.__version__.encode())
    for folder in ("", "space", "systems", "nervous", "learning", "genomes"):
        for path in sorted((_ROOT / folder).glob("*.py")):
            source = path.read_bytes()
            if b"njit" in source:
                digest.update(path.name.encode() + source)
    return digest.hexdigest()[:12]


def cache_folder() -> Path:
    """The folder that compiled kernels are kept in; `ECS_ECO_CACHE` overrides its parent."""
    parent = os.environ.get("ECS_ECO_CACHE") or os.environ.get("NUMBA_CACHE_DIR")
    if parent is None:
        parent = os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache"), "ecs-eco")
    return Path(parent) / f"kernels-{_sources_hash()}"


numba.config.CACHE_DIR = str(cache_folder())  # type: ignore[attr-defined]


def njit(function: Callable[..., Any]) -> Any:
    """Compile a kernel on first use, keep it on disk, release the GIL while it runs, follow IEEE on division by 0."""
    return numba.njit(cache=True, nogil=True, error_model="numpy")(function)

