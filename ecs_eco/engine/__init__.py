"""The core of the framework: components, tables, systems, the clock, births, deaths, random numbers, errors,
files.

This package knows nothing of space, biology or esper's entities, which belong to `ecs_eco.space` and above
and to `ecs_eco.esper_bridge`. Compiling kernels and dividing them among threads belongs to
`ecs_eco.compiled`.
"""
