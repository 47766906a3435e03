"""Compilation of kernels and their execution on several threads: the only package that knows numba's
internals, machine code and processors.

`jit` has the `njit` of this package, `portable` the mode with the same results on every machine, `libm` and
`elementary` its functions, `workers` the threads of a world. `numba_private` has all private names of numba,
`plain` the version without them. Columns and the clock belong to `ecs_eco.engine`.
"""
