"""Checks across sections of a world file, each problem at its key.

Limits of a single key belong to its model in `ecs_eco.config.models`.
"""
