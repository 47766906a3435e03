"""A world of lambs and ewes: the world file, and the systems that only it needs.

A system that other worlds could use belongs to `ecs_eco.systems`.
"""
