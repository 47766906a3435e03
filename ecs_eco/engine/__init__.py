"""Entities as columns: components, tables, systems, the clock, random numbers, errors and files.

Nothing here knows space or biology: those belong to `ecs_eco.space` and above; how kernels are compiled and
divided among threads belongs to `ecs_eco.compiled`.
"""
