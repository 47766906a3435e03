"""The size of newborn and of founders, of species that grow."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import Body, Stature, Traits

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

Values = dict[tuple[type, str], np.ndarray]


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


def _bodies(table: Table, values: Values, n: int, share: Any) -> Values:
    """Return bodies of a share of the adult's mass, of the same shape."""
    known = table.defaults[Stature]
    mass, radius = (np.broadcast_to(values.get((Stature, f), known[f]), n) for f in ("mass", "radius"))
    share = np.asarray(share, np.float64)
    return {(Body, "mass"): mass * share.astype(np.float32),
            (Body, "radius"): radius * (share ** (1 / 3)).astype(np.float32)}
