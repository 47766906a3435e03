"""Entities as columns: components, tables, systems, the clock, threads, random numbers, errors and files.

Nothing here knows space or biology: those belong to `ecs_eco.space` and above. Everything else may import the
engine.
"""
