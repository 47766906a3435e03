"""Real land: read rasters and vector layers, and extract the part that a world covers.

`ecs_eco.life.land` implements the effects of land on a world.
"""
