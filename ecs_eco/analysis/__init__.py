"""Statistics and figures of recorded runs, one phenomenon per file.

Functions take run folders or tables of series. Running worlds belongs to `ecs_eco.runs`, running many of them
to `ecs_eco.lab`. Nothing here imports numba, torch or esper, and matplotlib is imported only when a figure is
drawn.
"""
