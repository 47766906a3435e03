"""Runs that leave a folder: begun, stopped, resumed, forked, repeated.

One run belongs here, many runs to `ecs_eco.lab`, the files in a run's folder to `ecs_eco.record`.
"""
