"""How a world is built from its configuration, with which policies; the shipped worlds, a folder each.

A shipped world's folder holds what only that world needs. What a file may say belongs to `ecs_eco.config`;
what several worlds could use, to `ecs_eco.systems` or `ecs_eco.nervous.sensors`.
"""
