"""A world's state as arrays and JSON, and the file that holds it.

When checkpoints are written belongs to `ecs_eco.runs`; what a part keeps of itself, to its own `state`
and `load`.
"""
