"""The `njit` of this package: cached on disk, free of the GIL, and recompiled when any kernel's source
changes."""

from collections.abc import Callable
from typing import Any

import numba

from ecs_eco.compiled import portable
from ecs_eco.compiled.kernel_folder import Folder, cache_folder
from ecs_eco.compiled.numba_version import plain

if plain():
    from ecs_eco.compiled.plain import c_function, kept_kernel
else:
    from ecs_eco.compiled.kernel import c_function, kept_kernel

portable.check()
if portable.on():
    numba.config.CPU_NAME, numba.config.CPU_FEATURES = portable.CPU, ""  # type: ignore[attr-defined]
FOLDER = Folder(cache_folder())
if portable.on():
    from ecs_eco.compiled.linking import install

    install(c_function, FOLDER)


def njit(function: Callable[..., Any], *, fastmath: bool | set[str] = False, noalias: bool = False) -> Any:
    """Compile a kernel on first use, and keep it on disk for later processes.

    Parameters
    ----------
    function : callable
        A function of arrays and numbers, as numba's nopython mode takes it. A parameter annotated with a named
        tuple takes one (`ecs_eco.compiled.views`).
    fastmath : bool or set of str, default False
        As numba's; ignored in the portable mode, because its results depend on the processor.
    noalias : bool, default False
        Promises that no array that the kernel writes overlaps another of its arrays. Loops that look numbers up
        at computed places are vectorized only then.

    Returns
    -------
    callable
        The kernel. It releases the GIL while it runs, and follows IEEE 754 on division by 0.

    Notes
    -----
    A function without a source file, such as one typed at a prompt, is compiled again in each process.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco import njit
    >>> @njit
    ... def burn(energy, cost):
    ...     for i in range(energy.size):
    ...         energy[i] -= cost
    >>> energy = np.array([1.0, 0.5], np.float32)
    >>> burn(energy, np.float32(0.25))
    >>> energy.tolist()
    [0.75, 0.25]
    """
    return kept_kernel(function, FOLDER, False if portable.on() else fastmath, noalias)


def lone_njit(function: Callable[..., Any]) -> Any:
    """Compile as `njit` does, with `noalias`: no array that the kernel writes overlaps another of its
    arrays."""
    return njit(function, noalias=True)
