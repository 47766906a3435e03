"""Statistics and figures of recorded runs, one phenomenon per file.

Functions accept run folders or tables of series. To run a world, use `ecs_eco.runs`; to run many worlds, use
`ecs_eco.lab`. This package never imports numba, torch or esper, and imports matplotlib only to draw a figure."""
