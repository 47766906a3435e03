"""Statistics and figures of recorded runs, one phenomenon a file.

Takes run folders or tables of series. Running worlds belongs to `ecs_eco.runs`, running many to
`ecs_eco.lab`. Nothing here imports numba, torch or esper, and matplotlib only when a figure is drawn.
"""
