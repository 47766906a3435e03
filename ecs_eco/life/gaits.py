"""The gaits of a species, or of its members if genes code for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco.genomes.own_values import own_value

if TYPE_CHECKING:
    from ecs_eco.compiled.per_row import Number
    from ecs_eco.engine.table import Table

SIGNS = {"left": 1.0, "right": -1.0, "up": 1.0, "down": -1.0}  # the sign of each direction


class Gaits(NamedTuple):
    """The actions that move a body, for kernels: layout i64[4, 3] is (start, n, default) for speed, turn,
    climb and pitch, (column of command, −1, −1) for a continuous action, or (0, 0, −1) for no action."""

    layout: np.ndarray
    speeds: np.ndarray  # f32[k] [m/s], or [high, k] if individual
    costs: np.ndarray
    turns: np.ndarray  # [rad/s]
    climbs: np.ndarray  # [m/s]
    pitches: np.ndarray  # [rad]
    drag: Number  # [1/s]


def own_gaits(table: Table) -> Gaits | None:
    """Return the gaits of a table; if a gene codes for any of them, all are individual: arrays [high, k] and
    drag [high]."""
    shared: Gaits | None = table.species.gaits
    traits = table.species.traits
    if shared is None or not traits or not any(key.startswith("locomotion.") for key in traits):
        return shared
    layout, drag = shared.layout, shared.drag
    way, groups = table.species.locomotion, table.species.nerves.groups
    names = groups.get("speed", [])
    if layout[0, 1] < 0:  # for a continuous speed, in the order that cost_between requires
        names = list(way.speed)
    speeds = _each(table, [(f"speed.{a}", way.speed.get(a, 0.0)) for a in names])
    costs = _each(table, [(f"cost.{a}", way.cost.get(a, 0.0)) for a in names])
    if layout[0, 1] < 0:
        order = np.argsort(speeds, axis=1, kind="stable")
        speeds, costs = np.take_along_axis(speeds, order, 1), np.take_along_axis(costs, order, 1)
    turns, climbs, pitches = (
        _each(table, [(key, value)] * len(groups.get(group, ())))
        * np.array([SIGNS.get(a, 0.0) for a in groups.get(group, ())] or [0.0], np.float32)
        for key, value, group in (
            ("turn", way.turn, "turn"),
            ("climb", way.climb, "climb"),
            ("pitch", way.pitch, "climb"),
        )
    )
    drag = own_value(table, "locomotion.drag", np.float32(drag))
    each = np.broadcast_to(np.asarray(drag, np.float32), table.high).copy()
    return Gaits(layout, speeds, costs, turns, climbs, pitches, each)


def _each(table: Table, values: Sequence[tuple[str, float]]) -> np.ndarray:
    """Return the values of some keys of `locomotion`: f32[high, keys], at least one column."""
    out = np.zeros((table.high, max(len(values), 1)), np.float32)
    for i, (key, value) in enumerate(values):
        out[:, i] = own_value(table, f"locomotion.{key}", np.float32(value))
    return out
