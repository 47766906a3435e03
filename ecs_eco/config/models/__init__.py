"""What a world file may say: a model for each section, with description, unit and limits of every key.

What must fit together across sections belongs to `ecs_eco.config.checks`.
"""
