"""Many worlds: treatments, arms, comparisons, trainings, and the processes that do the work. Nothing prints.

What one run is belongs to `ecs_eco.runs`, what results mean to `ecs_eco.analysis`, words for the terminal to
`ecs_eco.cli`.
"""
