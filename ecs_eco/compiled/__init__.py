"""Compilation of kernels and their execution on several threads: the only package that deals with numba's
internals, machine code and processors.

`jit` contains the package's `njit`; `portable`, the mode that gives the same results on every machine; `libm`
and `elementary`, the functions of that mode; and `workers`, the threads of a world. `numba_private` contains
all uses of numba's private names, and `plain` is the fallback without them. Columns and the clock belong in
`ecs_eco.engine`.
"""
