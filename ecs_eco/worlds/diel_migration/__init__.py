"""A sea of phytoplankton, copepods and krill under a sun: the world file, its policies, and a custom sense.

Code that other seas could use belongs to `ecs_eco.space` (water, sun) or `ecs_eco.nervous.sensors`.
"""
