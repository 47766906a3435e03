"""What a record keeps of the dying, read in one pass over their rows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.components import Metabolism, Position
from ecs_eco.engine.jit import njit

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table

NOTHING = np.zeros(0, np.float32)


class Dead(NamedTuple):
    """Of each of the dying, in their order: uid u64[k], x, y, z [m], energy, age [s], all f32[k], cause
    u8[k], killer u64[k]; and the sums f64[4] of their flows of this tick, in the order of FLOWS, and of their
    energies."""

    uid: np.ndarray
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    energy: np.ndarray
    age: np.ndarray
    cause: np.ndarray
    killer: np.ndarray
    sums: np.ndarray


def dead(table: Table, rows: np.ndarray, tick: int, dt: float, died: np.ndarray) -> Dead:
    """Return what is kept of rows i64[k], zeros where the table lacks the component; count their causes in
    `died` i32[256]."""
    columns: Any = table.columns
    k = rows.size
    p, m = columns.get(Position), columns.get(Metabolism)
    place = (NOTHING,) * 3 if p is None else (p.x, p.y, p.z)
    held = (NOTHING,) * 4 if m is None else (m.taken, m.burnt, m.given, m.energy)  # flows as in FLOWS
    numbers, who, cause = np.zeros((8, k), np.float32), np.empty((2, k), np.uint64), np.empty(k, np.uint8)
    gather(rows, tick, dt, table.uid, table.born, table.cause, table.killer, *place, *held,
           numbers, who, cause, died)
    sums = np.add.reduce(numbers[4:], axis=1, dtype=np.float64)
    return Dead(who[0], numbers[0], numbers[1], numbers[2], numbers[7], numbers[3], cause, who[1], sums)


@njit
def gather(rows, tick, dt, uid, born, cause, killer, x, y, z, taken, burnt, given, energy,
           numbers, who, causes, died):
    """Write what `Dead` holds of each row: numbers f32[8, k] place, age, flows and energy, who u64[2, k] uid
    and killer, causes u8[k]; count these in died i32[256]."""
    for i in range(rows.size):
        row = rows[i]
        if x.size:
            numbers[0, i], numbers[1, i], numbers[2, i] = x[row], y[row], z[row]
        if energy.size:
            numbers[4, i], numbers[5, i], numbers[6, i] = taken[row], burnt[row], given[row]
            numbers[7, i] = energy[row]
        numbers[3, i] = np.float32((tick - born[row]) * dt)
        who[0, i], who[1, i], causes[i] = uid[row], killer[row], cause[row]
        died[cause[row]] += 1


def total(values: Any) -> Any:
    """Return the sum of values f32[k], in float64."""
    return np.add.reduce(values, dtype=np.float64)
