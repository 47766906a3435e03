"""Many worlds: treatments, arms, comparisons, training, and the processes that do the work.

Single runs belong to `ecs_eco.runs`, statistics to `ecs_eco.analysis`, output on the terminal to
`ecs_eco.cli`: nothing here prints.
"""
