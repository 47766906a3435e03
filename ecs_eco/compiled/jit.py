"""The package's `njit`: kernels are cached on disk, release the GIL, and are recompiled when any kernel's
source changes."""

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
    """Compile a kernel when it is first called, and cache it on disk for later processes.

    Parameters
    ----------
    function : callable
        A function of arrays and numbers that numba's nopython mode supports. Parameters can be annotated as
        named tuples (`ecs_eco.compiled.views`).
    fastmath : bool or set of str, default False
        The same as in numba; ignored in the portable mode, because its results depend on the processor.
    noalias : bool, default False
        A promise that no array to which the kernel writes overlaps another of its arrays. Without this, loops
        that read from computed positions are not vectorized.

    Returns
    -------
    callable
        The kernel, which releases the GIL while it runs and follows IEEE 754 on division by 0.

    Notes
    -----
    A function without a source file, such as one typed at a prompt, is compiled in each process.

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
    """Compile like `njit`, with `noalias`: no array to which the kernel writes may overlap another of its
    arrays."""
    return njit(function, noalias=True)
