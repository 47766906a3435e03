"""Eggs develop and hatch."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Body, Chemistry, Genome, Incubation, Metabolism, Parentage, Policy, Position
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.life import sizes
from ecs_eco.life.births import headings, newborn
from ecs_eco.life.climate import temperatures
from ecs_eco.life.matter import bodies, newborn_volumes

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

Values = dict[tuple[type, str], np.ndarray]

HATCHED = "hatched"  # the cause of death of a hatched egg


class Hatch(System):
    """An egg develops faster at higher temperatures and hatches at the end of its incubation: a newborn with
    the egg's energy, genome and parents replaces it.

    The rate is proportional to the number of degrees above a threshold (degree-days, Réaumur 1735), measured
    in the egg if it has a temperature, or otherwise in its surroundings. Eaten eggs do not hatch, and no egg
    hatches during pre-training.
    """

    needs = (Position, Metabolism, Parentage, Incubation)
    phase = "die"
    submodel = Submodel("Hatching", reads=("hatch",), changes=("Incubation",))
    asked_for = staticmethod(lambda table: table.species.hatch is not None)

    def start(self, world: SpatialWorld) -> None:
        """Register the cause of death of hatched eggs."""
        world.cause(HATCHED)
        world.bodiless.add(HATCHED)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Advance the development of one species' eggs and hatch those that are ripe."""
        way = table.species.hatch
        if way is None or not table.n or not world.reproduction:
            return
        high, developed = table.high, table[Incubation].developed
        world.split(
            develop,
            high,
            table.alive,
            temperatures(table, world),
            0.0 if way.temperature is None else way.temperature,
            way.threshold,
            world.dt,
            developed,
        )
        rows = table.by_uid()
        ripe = rows[(developed[rows] >= way.incubation * (1 - 1e-9)) & (table.cause[rows] == 0)]
        if ripe.size:
            table.cause[ripe] = world.cause(HATCHED)
            hatch(table, ripe, world.tables[way.into], world)


@njit
def develop(first, last, alive, temperature, usual, threshold, dt, developed):
    """Advance the development of living eggs by one tick; `usual` [K] is the reference temperature (0: none)."""
    for row in range(first, last):
        if alive[row]:
            rate = 1.0
            if usual > 0:
                rate = max((np.float64(temperature[row]) - threshold) / (usual - threshold), 0.0)
            developed[row] += rate * dt


def hatch(eggs: Table, rows: np.ndarray, into: Table, world: SpatialWorld) -> None:
    """Request the newborns that hatch from eggs in rows i64[k], in uid order: they get the eggs' positions,
    energy, substances, genomes and parents."""
    p, uid, parents = eggs[Position], eggs.uid[rows], eggs[Parentage]
    values = newborn(
        into, world, uid, p.x[rows], p.y[rows], p.z[rows], headings(world, uid), eggs[Metabolism].energy[rows]
    )
    mother, father = parents.mother[rows], parents.father[rows]
    if into.species.heredity is not None:
        values |= _inherited(eggs, rows, into, world, mother)
    values |= sizes.of_newborn(into, values, rows.size)
    if Chemistry in eggs and Chemistry in into:  # amounts stay the same
        radius = values.get((Body, "radius"), into.defaults[Body]["radius"])
        share = bodies(eggs).volume[rows] / np.maximum(newborn_volumes(into, radius), 1e-90)
        values[Chemistry, "molarity"] = (eggs[Chemistry].molarity[rows] * share[:, None]).astype(np.float32)
    if Parentage in into:
        values |= {(Parentage, "mother"): mother, (Parentage, "father"): father}
    into.request(mother, values, father)


def _inherited(eggs: Table, rows: np.ndarray, into: Table, world: SpatialWorld, mother: np.ndarray) -> Values:
    """Return the inherited columns of newborns; newborns from eggs without a mother get a founder's values."""
    heredity = into.species.heredity
    assert heredity is not None
    carried = {
        (c, f): eggs.field(c, f)[rows] for c in (Genome, Policy) if c in eggs for f in eggs.defaults[c]
    }
    values = heredity.express(into, carried[Genome, "loci"]) if Genome in eggs else {}
    values |= carried
    if not (first := mother == 0).any():
        return values
    for name, founder in heredity.founders(world, into, eggs.uid[rows][first]).items():
        values[name] = np.array(values[name])
        values[name][first] = founder
    return values
