"""Code that applies a world file to a live world, and code that systems share: species, founders, births,
matter, meals.

`apply` and `reconfigure` give a world the values of its file. Systems belong in `ecs_eco.systems`, which runs
them in each tick.
"""
