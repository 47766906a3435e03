"""Checks across sections of a world file; each problem is reported at its key.

The limits of single keys are in their models, in `ecs_eco.config.models`.
"""
