"""Recorded runs: how they are started, stopped, resumed, forked and repeated.

For many runs, use `ecs_eco.lab`; `ecs_eco.record` defines the files in a run's folder.
"""
