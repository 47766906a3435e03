"""Curve points of a live world that is being watched."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from ecs_eco.components import Genome, Metabolism, Nervous, Position, Velocity
from ecs_eco.ecosystem import World
from ecs_eco.view import flows
from ecs_eco.view.curves import DEPTH, Key, Point, died
from ecs_eco.view.journal import Journal
from ecs_eco.view.scene import sky


def point(world: World, journal: Journal, genes: Mapping[str, Collection[str]]) -> Point:
    """Return the current point of all curves. `genes` are the genes of each species that have curves.

    The point's sums are the births, deaths by cause, and energy flows so far.
    """
    sums, words = flows.of_world(world.recorder), ["unknown", *world.causes]
    for s, name in enumerate(genes):
        of = journal.died[s]
        causes = [(words[c], float(of[c])) for c in np.flatnonzero(of).tolist()]
        sums |= died(name, causes, float(journal.born[s]))
    return Point(world.tick, _levels(world, genes), sums)


def _levels(world: World, genes: Mapping[str, Collection[str]]) -> dict[Key, float]:
    """Return population sizes, mean happiness (undefined before the first tick), gene means, depths, light
    and the latest reports. Without a recorder, also return the energy that living organisms took in and
    burned in the last tick."""
    out: dict[Key, float] = {("light", ""): sky(world)[0]}
    for name in genes:
        out["n", name] = int(world.tables[name].n)
        if out["n", name]:
            out |= _means(world, name, genes[name])
    recorder = world.recorder
    if recorder is None:
        reports = {name: world.measure(name) for name in world.reporters}
    else:
        reports = {} if recorder.reports is None else recorder.reports.latest
    for name, report in reports.items():
        for species, value in (report if isinstance(report, dict) else {"": report}).items():
            out["reports", name, species] = value
    return out


def _means(world: World, name: str, genes: Collection[str]) -> dict[Key, float]:
    def mean(values: np.ndarray) -> float:
        return float(values.mean(dtype=np.float64))

    out: dict[Key, float] = {}
    table = world.tables[name]
    rows = table.rows()
    if world.tick and Nervous in table and table.species.nerves.happiness is not None:
        out["happiness", name] = mean(table[Nervous].happiness[rows])
    if genes:
        decoded = table.species.heredity.layout.decode(table[Genome].loci[rows], list(genes))
        out |= {("genes", f"{name}.{gene}"): mean(values) for gene, values in decoded.items()}
    if world.tick and Metabolism in table and world.recorder is None:
        m = table[Metabolism]
        out["energy", name, "taken in"] = float(m.taken[rows].sum(dtype=np.float64))
        out["energy", name, "burnt"] = float(m.burnt[rows].sum(dtype=np.float64))
    if world.tick and world.space.volume and Velocity in table:  # as heights below 0 [m]
        out["reports", DEPTH, name] = mean(table[Position].z[rows]) - float(world.space.size[2])
    return out
