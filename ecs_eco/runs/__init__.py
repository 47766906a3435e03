"""Runs that leave a folder: begun, stopped, resumed, forked, repeated.

One run is the business here; many of them are that of `ecs_eco.experiments`, the files in its folder that of
`ecs_eco.record` and `ecs_eco.checkpoint`.
"""
