"""What a species can be or do, one feature a file: keys of the world file, their checks, and what they bring.

`ecs_eco.config.models.species.Species` is assembled from these. A feature names components; its systems read
its keys from `table.species`. It imports no numba.
"""
