"""The young grow to adult size."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Body, Metabolism, Stature
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_values

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

ROOTS = {"von_bertalanffy": 1.0 / 3.0, "west": 0.25}  # exponents of mass in the growth laws


class Law(NamedTuple):
    """Growth of bodies, for kernels."""

    root: float  # exponent of mass in the growth law
    step: Number  # rate × dt, or f32[rows]
    standard: float  # [kg] adult mass to which `step` applies; 0: any
    cost: Number  # energy per kilogram
    reserve: Number  # energy that growth must not use


class GrowUp(System):
    """A body that is smaller than an adult's grows to the extent that its owner can pay for new tissue.

    The cube root of its mass approaches the adult's at a constant rate (von Bertalanffy 1957), or its fourth
    root does so (West, Brown & Enquist 2001) at a rate that falls with the fourth root of the adult's mass.
    Growth is solved exactly. Each kilogram costs energy, which only the energy above the reserve can pay for;
    a body that cannot pay grows less and catches up later. The radius grows with the cube root of the mass.
    """

    needs = (Body, Metabolism, Stature)
    phase = "metabolise"
    submodel = Submodel(
        "Growth of the young",
        reads=("growth",),
        rules={
            "growth.law=von_bertalanffy": "`d(m^(1/3))/dt = rate (M^(1/3) − m^(1/3))`, where M is the adult mass "
            "(von Bertalanffy 1957).",
            "growth.law=west": "`d(m^(1/4))/dt = rate (M^(1/4) − m^(1/4))`, where M is the adult mass "
            "(West, Brown & Enquist 2001).",
        },
        changes=("Body", "Stature.residue", "Metabolism.energy", "Metabolism.burnt"),
    )
    asked_for = staticmethod(lambda table: table.species.growth is not None)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Grow the young of one species."""
        way, b, s, m, high = (
            table.species.growth,
            table[Body],
            table[Stature],
            table[Metabolism],
            table.high,
        )
        if way is None or not (table.alive[:high] & (b.mass[:high] < s.mass[:high])).any():
            return
        rate, cost, reserve = own_values(
            table, {"growth.rate": way.rate, "growth.cost": way.cost, "growth.reserve": way.reserve}
        )
        standard = table.species.standard_mass if way.law == "west" else 0.0
        world.split(
            grow_up,
            high,
            table.alive,
            s.mass,
            s.radius,
            Law(ROOTS[way.law], rate * world.dt, standard, cost, reserve),
            b.mass,
            b.radius,
            s.residue,
            m.energy,
            m.burnt,
        )
        table.version += 1  # bodies that have grown may touch and hide other bodies


@njit
def grow_up(
    first: int,
    last: int,
    alive: np.ndarray,
    adult_mass: np.ndarray,
    adult_radius: np.ndarray,
    law: Law,
    mass: np.ndarray,
    radius: np.ndarray,
    residue: np.ndarray,
    energy: np.ndarray,
    burnt: np.ndarray,
) -> None:
    """Grow living bodies for one tick."""
    root, step, standard, cost, reserve = law
    for row in range(first, last):
        if not alive[row] or mass[row] >= adult_mass[row]:
            continue
        most, before = np.float64(adult_mass[row]), np.float64(mass[row]) + residue[row]
        stride, price = of_row(step, row), of_row(cost, row)
        far = stride * (standard / most) ** root if standard > 0 else stride
        share = 1.0 - (1.0 - (before / most) ** root) * np.exp(-far)
        gain = max(most * share ** (1.0 / root) - before, 0.0)
        if price > 0:
            gain = min(gain, max(np.float64(energy[row]) - of_row(reserve, row), 0.0) / price)
            held = energy[row]
            energy[row] = held - gain * price
            burnt[row] += held - energy[row]
        mass[row] = before + gain
        residue[row] = before + gain - mass[row]
        radius[row] = adult_radius[row] * ((before + gain) / most) ** (1.0 / 3.0)
