"""Many worlds: comparisons of arms, grids of seeds, pre-training and the processes that do the work.

What one run is belongs to `ecs_eco.runs`, what results mean to `ecs_eco.analysis`.
"""
