"""The size of newborn and of founders, of species that grow, and what follows from it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Body, Stature, Traits
from ecs_eco.engine.elementary import power
from ecs_eco.genomes.own_values import own_value

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

Values = dict[tuple[type, str], np.ndarray]
TINY = np.float32(1e-30)  # [kg]


def of_newborn(table: Table, values: Values, n: int) -> Values:
    """Return mass and radius of `n` newborn whose other columns are `values`; {} if the species does not
    grow."""
    way = table.species.growth
    if way is None:
        return {}
    at = table.species.traits.get("growth.newborn")
    return _bodies(table, values, n, way.newborn if at is None else values[Traits, "value"][:, at])


def of_adults(table: Table, values: Values, n: int) -> Values:
    """Return mass and radius of `n` adults whose other columns are `values`; {} if the species does not
    grow."""
    return {} if table.species.growth is None else _bodies(table, values, n, 1.0)


def share_of_adult(table: Table) -> np.ndarray:
    """Return the mass of each body as a share of that of an adult, at most 1: f32[high]."""
    share = table[Body].mass[: table.high] / np.maximum(table[Stature].mass[: table.high], TINY)
    least: np.ndarray = np.minimum(share, np.float32(1))
    return least


def of_size(table: Table, store: Any) -> Any:
    """Return the most energy that bodies of a species can hold, of which adults hold `store`, a number or an
    array [high]: that, or where the young hold less an array [high] of its type."""
    way = table.species.growth
    if way is None:
        return store
    exponent = own_value(table, "growth.store", np.float32(way.store))
    if not isinstance(exponent, np.ndarray) and exponent == 0:
        return store
    return np.asarray(store * power(share_of_adult(table), exponent), getattr(store, "dtype", np.float64))


def _bodies(table: Table, values: Values, n: int, share: Any) -> Values:
    """Return bodies of a share of the adult's mass, of the same shape."""
    known = table.defaults[Stature]
    mass, radius = (np.broadcast_to(values.get((Stature, f), known[f]), n) for f in ("mass", "radius"))
    share = np.asarray(share, np.float64)
    return {(Body, "mass"): mass * share.astype(np.float32),
            (Body, "radius"): radius * power(share, 1 / 3).astype(np.float32)}
