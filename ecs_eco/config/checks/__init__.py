"""Checks across sections, each problem at its key; limits of a single key belong to `ecs_eco.config.models`."""
