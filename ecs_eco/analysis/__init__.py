"""Statistics and figures of what runs left behind, one file a phenomenon.

Takes run folders or tables of series and runs no world: that belongs to `ecs_eco.runs`, many of them to
`ecs_eco.experiments`. Nothing here imports numba, torch or esper, and matplotlib only when a figure is drawn.
"""
