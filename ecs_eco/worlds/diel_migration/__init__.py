"""A sea of phytoplankton, copepods and krill under a sun: the world file, its policies, a sense of its own.

What other seas could use belongs to `ecs_eco.space` (water, sun) or `ecs_eco.nervous.sensors`.
"""
