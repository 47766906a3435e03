"""The contents of a world file: a model for each section, with the description, unit and range of every key.

`ecs_eco.config.checks` contains the checks across sections.
"""
