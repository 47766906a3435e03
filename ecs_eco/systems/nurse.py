"""Parents feed their young."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Biology, Body, Metabolism, Nervous, Parentage, Position, Shape
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import highest, own_value, own_values
from ecs_eco.life.births import rows_of
from ecs_eco.life.sizes import of_size
from ecs_eco.space.bodies import form_of
from ecs_eco.space.geometry import Extent, Places
from ecs_eco.space.shapes import touching
from ecs_eco.space.sight import offset

if TYPE_CHECKING:
    from ecs_eco.config.features.life_history import Care
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

NO_DECISION = np.zeros((1, 1), np.uint8)
SPHERES = np.zeros((0, 9), np.float32)  # empty `form`: all bodies are spheres
PARENTS = {"mother": ("mother",), "father": ("father",), "both": ("mother", "father")}


class Nurse(System):
    """A parent with more energy than its reserve gives energy at a given rate to each of its young within
    reach, until they are full or old enough.

    If it cannot meet all demands, each young animal gets the same share of its demand. The part of the
    payment that does not reach the young is burned. A parent with a `nurse` action feeds its young when it
    decides to; a parent without it feeds them whenever it can. If both parents feed, the mother feeds first.
    """

    needs = (Position, Body, Metabolism, Biology, Parentage)
    phase = "interact"
    submodel = Submodel(
        "Parental care",
        reads=("care",),
        rules={
            "": "`dE_young/dt = efficiency × rate` while the parent has more energy than its reserve; the parent "
            "pays `rate`."
        },
        changes=("Metabolism.energy", "Metabolism.taken", "Metabolism.given", "Metabolism.burnt"),
    )
    asked_for = staticmethod(lambda table: table.species.care is not None)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Feed the young of one species."""
        way, b = table.species.care, table[Biology]
        if way is None or not table.n:
            return
        rows = table.by_uid()
        until = own_value(table, "care.age_max", np.float32(way.age_max))
        young = rows[(b.age[rows] < np.float32(highest(until, table.alive))) & (table.cause[rows] == 0)]
        for parent in PARENTS[way.by] if young.size else ():
            its = rows_of(table, getattr(table[Parentage], parent)[young])
            fed = its >= 0
            if isinstance(until, np.ndarray):  # individual values
                fed &= b.age[young] < until[its]
            self.feed(table, world, way, young[fed], its[fed])

    def feed(
        self, table: Table, world: SpatialWorld, way: Care, young: np.ndarray, parent: np.ndarray
    ) -> None:
        """Move energy from rows `parent` i64[k] to rows `young` i64[k], which are in uid order."""
        p, m, nerves = table[Position], table[Metabolism], table.species.nerves
        column = (
            -1
            if nerves is None
            else next((i for i, (group, _) in enumerate(nerves.actions) if group == "nurse"), -1)
        )
        decision = table[Nervous].decision if column >= 0 else NO_DECISION
        form = form_of(table, np.arange(table.high)) if Shape in table else SPHERES
        reach, rate, reserve, efficiency, full = own_values(
            table,
            {
                "care.reach": np.float32(way.reach),
                "care.rate": way.rate,
                "care.reserve": way.reserve,
                "care.efficiency": way.efficiency,
                "metabolism.energy_max": table.species.metabolism.energy_max,
            },
        )
        nurse(
            young,
            parent,
            Places(p.x, p.y, p.z),
            table[Body].radius,
            form,
            world.space.extent,
            decision,
            column,
            table.cause[: table.high],
            Caring(reach, rate * world.dt, reserve, efficiency, of_size(table, full)),
            Energy(m.energy, m.taken, m.given, m.burnt),
        )


class Caring(NamedTuple):
    """Feeding of young, for kernels: numbers, or arrays [rows] with one value per parent."""

    reach: Number  # [m]
    most: Number  # energy per young animal per tick
    reserve: Number  # energy that a parent keeps
    efficiency: Number  # share that arrives
    full: Number  # maximum energy of young


class Energy(NamedTuple):
    """Energy and its flows, for kernels: f32[rows]."""

    energy: np.ndarray
    taken: np.ndarray
    given: np.ndarray
    burnt: np.ndarray


@njit
def nurse(
    young: np.ndarray,
    parent: np.ndarray,
    places: Places,
    radius: np.ndarray,
    form: np.ndarray,
    space: Extent,
    decision: np.ndarray,
    column: int,
    cause: np.ndarray,
    care: Caring,
    store: Energy,
) -> None:
    """Move energy from parents to young."""
    (x, y, z), (energy, taken, given, burnt) = places, store
    reach, most, reserve, efficiency, full = care
    gets, demand, gives = np.zeros(young.size), np.zeros(cause.size), np.zeros(cause.size)
    for k in range(young.size):
        one, it = young[k], parent[k]
        dx, dy, dz = offset(x[one], y[one], z[one], x[it], y[it], z[it], space)
        near_to = of_row(reach, it)
        far, feeds = radius[one] + radius[it] + near_to, column < 0 or decision[it, column] != 0
        near = dx * dx + dy * dy + dz * dz <= far * far
        if len(form):
            ax, ay, az = np.float64(-dx), np.float64(-dy), np.float64(-dz)
            gap, _, _, _ = touching(form, one, form, it, ax, ay, az, space)
            near = gap <= near_to
        if feeds and cause[it] == 0 and near:
            wants = max(of_row(full, one) - energy[one], 0.0) / of_row(efficiency, it)
            gets[k] = min(of_row(most, it), wants)
            demand[it] += gets[k]
    for k in range(young.size):  # before any energy moves, because a parent may itself be fed
        it = parent[k]
        if gets[k] > 0:
            gets[k] *= min(max(energy[it] - of_row(reserve, it), 0.0) / demand[it], 1.0)
            gives[it] += gets[k]
    for k in range(young.size):
        one, it = young[k], parent[k]
        if gives[it] > 0:
            before = energy[it]
            energy[it] = before - gives[it]
            lost = np.float32((before - energy[it]) * (1.0 - of_row(efficiency, it)))
            burnt[it] += lost
            given[it] += before - energy[it] - lost
            gives[it] = 0.0
    for k in range(young.size):
        if gets[k] > 0:
            before = energy[young[k]]
            energy[young[k]] = before + gets[k] * of_row(efficiency, parent[k])
            taken[young[k]] += energy[young[k]] - before
