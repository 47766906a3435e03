"""Traits and abilities of species and object types: keys in the world file, their checks, and their effects.

`ecs_eco.config.models.species.Species` and `ecs_eco.config.models.surroundings.ObjectType` are assembled from
these features. A feature names components; its systems read its keys from `table.species`. Its module must not
import numba.
"""
