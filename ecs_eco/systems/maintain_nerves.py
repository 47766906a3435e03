"""Nervous systems burn energy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.components import LearningRates, Metabolism, NeuralCost, Traits
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.heredity import hidden_units
from ecs_eco.life.torpor import awake

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class MaintainNerves(System):
    """An organism burns energy for the hidden units of its network, for its receptors, and for each
    transition that it records to learn from. An organism that can fall into torpor burns no more than it has.
    """

    needs = (Metabolism, NeuralCost)
    phase = "metabolise"
    divisible = True
    submodel = Submodel(
        "Metabolism",
        where=("neural_costs",),
        reads=("neural_costs",),
        rules={
            "": "The nervous system burns `hidden_unit × units + receptor × channels` per second and, in "
            "each tick of learning, `transition × learning rate/ppo.learning_rate`."
        },
        changes=("Metabolism.energy", "Metabolism.burnt", "NeuralCost"),
    )
    asked_for = staticmethod(lambda table: table.species.neural_costs is not None)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Burn the energy of one species' nervous systems for one tick."""
        if (way := table.species.neural_costs) is None:
            return
        m, rows = table[Metabolism], np.flatnonzero(table.alive[: table.high])
        costs = np.empty((3, rows.size))
        costs[0] = way.hidden_unit * world.dt * units(table, rows)
        costs[1] = way.transition * transitions(table, rows)
        costs[2] = way.receptor * world.dt * receptors(table, rows)
        before, total = m.energy[rows], costs[0] + costs[1] + costs[2]
        if table.species.metabolism.torpor:
            most = np.maximum(before, 0.0)
            costs *= np.divide(most, total, out=np.ones(rows.size), where=total > most)
            total = np.minimum(total, most)
        m.energy[rows] = after = (before - total).astype(np.float32)
        m.burnt[rows] += before - after
        paid = table[NeuralCost]
        paid.brain[rows], paid.learning[rows], paid.senses[rows] = costs


def units(table: Table, rows: np.ndarray) -> Any:
    """Return the number of hidden units of the organisms in rows i64[n], which all share it unless a gene
    codes for it."""
    own = hidden_units(table)
    return sum(
        table[Traits].value[rows, own[layer]] if layer in own else size
        for layer, size in enumerate(table.species.policy.hidden)
    )


def receptors(table: Table, rows: np.ndarray) -> Any:
    """Return the number of sensor channels of the organisms in rows i64[n], except those of sensors that they
    lack."""
    species = table.species
    n: Any = len(species.nerves.channels) if species.nerves is not None else 0
    for sensor, (_, width) in zip(species.sensors, species.nerves.senses if n else (), strict=False):
        if (at := species.traits.get(f"sensors.{sensor.name}.present")) is not None:
            n = n - width * (table[Traits].value[rows, at] < 0.5)
    return n


def transitions(table: Table, rows: np.ndarray) -> Any:
    """Return the transitions that the organisms in rows i64[n] record in this tick, each multiplied by the
    organism's learning rate relative to the species': f64[n], or one number for all."""
    nerves, species = table.species.nerves, table.species
    if nerves is None or not nerves.learning:
        return 0.0
    n: Any = awake(table)[rows].astype(float) if species.metabolism.torpor else 1.0
    if LearningRates in table:
        n = n * (table[LearningRates].learning_rate[rows] / np.float32(species.ppo["learning_rate"])).astype(
            float
        )
    return n
