"""How kernels are compiled and run on several threads: all that knows numba's inside, machine code or processors.

`jit` has the `njit` of this package, `portable` the mode with the same results on every machine, `libm` and
`elementary` its functions, `workers` the threads of a world. `numba_private` has all private names of numba,
`plain` what does without them. Columns and the clock belong to `ecs_eco.engine`.
"""
