"""Mothers share their substances with their newborns."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Chemistry, Matter
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.life.births import rows_of
from ecs_eco.life.matter import Bodies, bodies, book, held, hold

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Provide(System):
    """A mother shares her substances with her newborns so that all have equal concentrations.

    The same applies to the two halves of a dividing cell. Newborns without a living parent keep their initial
    substances.
    """

    needs = (Chemistry, Matter)
    phase = "reproduce"
    submodel = Submodel(
        "Substances of newborns",
        reads=("born_with",),
        rules={
            "": "`c ← c V/(V + ΣV_young)` in the mother and in her young, where V is the volume of a body."
        },
        changes=("Chemistry", "Matter"),
    )
    asked_for = staticmethod(lambda table: table.species.born_with == "mother")
    world: SpatialWorld

    def start(self, world: SpatialWorld) -> None:
        """Listen for births."""
        world.on_birth.append(self.share)

    def process(self, *_: object) -> None:
        """Do nothing: substances are shared when a birth takes effect."""

    def share(self, table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        """Share mothers' substances with newborns of one species in rows i64[k]; parents u64[k] are uids."""
        if table.species.born_with != "mother" or Matter not in table:
            return
        young = rows[parents != 0]
        mothers = rows_of(table, parents[parents != 0])
        known = mothers >= 0
        given = np.zeros(table[Chemistry].molarity.shape[1])
        divide(young[known], mothers[known], bodies(table), given)
        book(self.world, table, "endowed", -given)  # the same amount is recorded for the newborns


@njit
def divide(young: np.ndarray, mothers: np.ndarray, bodies: Bodies, given: np.ndarray) -> None:
    """Equalize the concentrations of mothers and their young; add the amounts that mothers give to `given`
    f64[substances] [mol]."""
    volume, substances = bodies.volume, bodies.molarity.shape[1]
    together = np.zeros(volume.size)  # [L] total volume of a mother's newborns
    for i in range(young.size):
        together[mothers[i]] += volume[young[i]]
    for i in range(young.size):
        row = mothers[i]
        if together[row] > 0:
            for s in range(substances):
                before = held(bodies, row, s)
                now = hold(bodies, row, s, before * volume[row] / (volume[row] + together[row]))
                given[s] += (before - now) * volume[row]
            together[row] = 0.0
        for s in range(substances):
            hold(bodies, young[i], s, held(bodies, row, s))
