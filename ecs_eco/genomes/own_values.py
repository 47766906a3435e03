"""Individual values, which replace the species' values if genes code for them."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ecs_eco.compiled.per_row import Number
from ecs_eco.components import Traits
from ecs_eco.engine.table import Table


def own_values(table: Table, shared: Mapping[str, Any]) -> tuple[Any, ...]:
    """Return the values of keys in the world file: unchanged if no gene codes for any of them; otherwise, all
    are arrays [table.high], with individual values for keys that genes code for.

    Kernels are therefore compiled at most twice: for shared and for individual values. Arrays have the type
    of the given values, or f64 for Python numbers. Keys are dotted and relative to the species' section.
    """
    coded = table.species.traits
    if not coded or coded.keys().isdisjoint(shared):
        return tuple(shared.values())
    return tuple(_column(table, coded.get(key), value) for key, value in shared.items())


def own_value(table: Table, key: str, shared: Any) -> Any:
    """Return the value of a key in the world file for each organism.

    Parameters
    ----------
    table : Table
    key : str
        Dotted key within the species' section, such as "metabolism.basal".
    shared : float
        The value that all organisms share if no gene codes for the key.

    Returns
    -------
    float or array, shape (table.high,)
        `shared` itself, or each organism's value by row.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.genomes.own_values import own_value
    >>> deer = World.from_config("predator-prey", seed=1).table("deer")
    >>> own_value(deer, "metabolism.basal", deer.species.metabolism.basal)
    0.004
    """
    return own_values(table, {key: shared})[0] if table.species.traits else shared


def highest(value: Number, alive: np.ndarray) -> float:
    """Return the maximum over some rows, or the value itself if it is shared."""
    if not isinstance(value, np.ndarray):
        return float(value)
    return float(value[alive[: value.size]].max(initial=0.0))


def _column(table: Table, at: int | None, value: Any) -> np.ndarray:
    kind = getattr(value, "dtype", np.float64)
    if at is None:
        return np.full(table.high, value, kind)
    return table[Traits].value[: table.high, at].astype(kind)
