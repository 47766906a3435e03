"""What species and object types can be or do: keys of the world file, their checks, and what they bring.

`ecs_eco.config.models.species.Species` and `ecs_eco.config.models.surroundings.ObjectType` are assembled from
these. A feature names components; its systems read its keys from `table.species`. It imports no numba.
"""
