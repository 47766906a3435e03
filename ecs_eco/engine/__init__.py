"""The core of the framework: components, tables, systems, the clock, births, deaths, random numbers, errors,
files.

This package does not deal with space, biology or esper entities, which belong in `ecs_eco.space`, the layers
above it and `ecs_eco.esper_bridge`. Code that compiles kernels and divides them among threads belongs in
`ecs_eco.compiled`.
"""
