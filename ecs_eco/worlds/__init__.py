"""World building from a configuration, with policies; the shipped worlds, a folder each.

A shipped world's folder contains only what that world needs. Models of world files belong to
`ecs_eco.config`; code for several worlds belongs to `ecs_eco.systems` or `ecs_eco.nervous.sensors`.
"""
