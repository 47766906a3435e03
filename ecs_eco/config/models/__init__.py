"""The contents of a world file: a model for each section, with description, unit and limits of every key.

Checks across sections belong to `ecs_eco.config.checks`.
"""
