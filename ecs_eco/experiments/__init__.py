"""Many worlds: treatments, arms, comparisons, training, and the processes that do the work.

What one run is belongs to `ecs_eco.runs`, what results mean to `ecs_eco.analysis`, words for the terminal to
`ecs_eco.cli`: nothing here prints.
"""
