"""What a world file may mean: checks across sections, each problem at its key.

Limits of a single key belong to its model in `ecs_eco.config.models`.
"""
