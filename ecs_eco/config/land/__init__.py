"""Real land: rasters and vector layers as they are read, and the part of them that a world covers.

What they do to a world belongs to `ecs_eco.life.land`.
"""
