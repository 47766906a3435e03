"""Runs that leave a folder: starting, stopping, resuming, forking, repeating.

Many runs belong to `ecs_eco.lab`, the files in a run's folder to `ecs_eco.record`.
"""
