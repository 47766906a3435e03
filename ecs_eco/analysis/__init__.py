"""Statistics and figures of recorded runs, one phenomenon per file.

Functions take run folders or tables of series. Running worlds belongs to `ecs_eco.runs`, running many of them
to `ecs_eco.lab`. numba, torch and esper are never imported here, and matplotlib only to draw a figure.
"""
