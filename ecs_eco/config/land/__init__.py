"""Real land: rasters and vector layers as read from files, and the part that a world covers.

`ecs_eco.life.land` implements the effects of land on a world.
"""
