"""Entities as columns: components, tables, systems, the clock, births and deaths, random numbers, errors and files.

Nothing here knows space, biology or esper's entities: those belong to `ecs_eco.space` and above, and to
`ecs_eco.esper_bridge`; how kernels are compiled and divided among threads belongs to `ecs_eco.compiled`.
"""
