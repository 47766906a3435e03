"""What a world file does to a living world, and what systems share: species, founders, births, matter, meals.

`apply` and `reconfigure` give a world the values of its file. No system belongs here: `ecs_eco.systems` decides
when things happen.
"""
