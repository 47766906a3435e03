"""Eggs: what they carry of those that laid them, and who hatches from them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.components import Body, Chemistry, Genome, Metabolism, Parentage, Policy, Position
from ecs_eco.lifecycle import sizes
from ecs_eco.lifecycle.births import headings, newborn
from ecs_eco.lifecycle.matter import bodies, newborn_volumes

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

Values = dict[tuple[type, str], np.ndarray]


def hatch(eggs: Table, rows: np.ndarray, into: Table, world: SpatialWorld) -> None:
    """Request the newborn that hatch from eggs, rows i64[k] in the order of uids: where these lie, with their
    energy, substances, genome and parents."""
    p, uid, parents = eggs[Position], eggs.uid[rows], eggs[Parentage]
    values = newborn(
        into, world, uid, p.x[rows], p.y[rows], p.z[rows], headings(world, uid), eggs[Metabolism].energy[rows]
    )
    mother, father = parents.mother[rows], parents.father[rows]
    if into.species.heredity is not None:
        values |= _inherited(eggs, rows, into, world, mother)
    values |= sizes.of_newborn(into, values, rows.size)
    if Chemistry in eggs and Chemistry in into:  # amounts stay
        radius = values.get((Body, "radius"), into.defaults[Body]["radius"])
        share = bodies(eggs).volume[rows] / np.maximum(newborn_volumes(into, radius), 1e-90)
        values[Chemistry, "molarity"] = (eggs[Chemistry].molarity[rows] * share[:, None]).astype(np.float32)
    if Parentage in into:
        values |= {(Parentage, "mother"): mother, (Parentage, "father"): father}
    into.request(mother, values, father)


def _inherited(eggs: Table, rows: np.ndarray, into: Table, world: SpatialWorld, mother: np.ndarray) -> Values:
    """Return the inherited columns of newborn; eggs that nobody laid are those of founders."""
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
