"""A world's state as arrays and JSON, and the file that holds it.

`ecs_eco.runs` decides when checkpoints are written; each part saves and loads itself by `state` and `load`.
"""
