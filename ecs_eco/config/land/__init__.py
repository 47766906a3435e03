"""Real land: reads rasters and vector layers from files and extracts the part that a world covers.

`ecs_eco.life.land` implements the effects of land on a world.
"""
