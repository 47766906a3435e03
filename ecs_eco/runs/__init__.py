"""Runs that leave a folder: starting, stopping, resuming, forking, repeating.

Single runs belong here, runs of many worlds to `ecs_eco.lab`, the files in a run's folder to
`ecs_eco.record`.
"""
