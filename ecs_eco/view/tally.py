"""Curve points of a world, from the series that it recorded."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from ecs_eco.components import Genome, Metabolism, Nervous, Position, Velocity
from ecs_eco.config.models.reporters import DIED
from ecs_eco.ecosystem import World
from ecs_eco.view import flows
from ecs_eco.view.curves import DEPTH, Curves, Key, died, extremes
from ecs_eco.view.journal import Journal
from ecs_eco.view.scene import sky

BATCH = 100  # maximum number of points added at once; of more ticks, the extremes are kept


def sample(curves: Curves, world: World, journal: Journal, genes: Mapping[str, Collection[str]]) -> None:
    """Add the points of all ticks since the last point that the world's recorder has in memory; without a
    recorder, the current state.

    `genes` are the genes of each species that have curves. Their means and the light are known only at the
    last point. Without a recorder, the energy that living organisms took in and burned in the last tick
    replaces the energy flows.
    """
    if curves.last >= world.tick:
        return
    species = list(genes)
    rows = None if world.recorder is None else world.recorder.since(max(curves.last, curves.first - 1) - 1)
    if rows is None or not rows["tick"].size:
        ticks = np.array([world.tick])
        levels, sums = _state(world, species), _journal(journal, world.causes, species)
        gains = {key: np.array([total - curves.total(key)]) for key, total in sums.items()}
    else:
        assert world.recorder is not None
        ticks = rows["tick"][:, 0] + 1  # the state after a tick has the number of the next tick
        order = [world.recorder.place[name] for name in species]
        rows = {name: column[:, order] for name, column in rows.items()}
        happy = [s for s in species if _feels(world, s)]
        levels = levels_of(rows, species, happy, [s for s in species if Velocity in world.tables[s]])
        levels |= _reports(world, rows, species)
        totals = {name: column.cumsum(axis=0, dtype=np.float64) for name, column in rows.items()}
        intake = world.recorder.intake
        gains = sums_of(totals, species, {world.recorder.names[s]: intake.foods for s in intake.eaters})
        if ticks.size > BATCH:
            kept = extremes(np.array([levels["n", s] for s in species]), BATCH)
            ticks = ticks[kept]
            levels, gains = ({key: of[kept] for key, of in some.items()} for some in (levels, gains))
    now = {("light", ""): sky(world)[0]} | _genes(world, genes)
    levels |= {key: np.append(np.full(ticks.size - 1, np.nan), value) for key, value in now.items()}
    curves.add(ticks, levels, gains)


def levels_of(
    columns: Mapping[str, np.ndarray], species: Sequence[str], happy: Collection[str], movers: Collection[str]
) -> dict[Key, np.ndarray]:
    """Return population sizes, mean happiness and mean heights below the surface [m] from columns of the
    series f[ticks, species]."""
    out: dict[Key, np.ndarray] = {}
    for s, name in enumerate(species):
        n = out["n", name] = columns["n"][:, s]
        if name in happy:
            out["happiness", name] = np.where(n > 0, columns["happiness_mean"][:, s], np.nan)
        if name in movers and "depth_mean" in columns:
            out["reports", DEPTH, name] = np.where(n > 0, -columns["depth_mean"][:, s], np.nan)
    return out


def sums_of(
    totals: Mapping[str, np.ndarray], species: Sequence[str], foods: Mapping[str, Sequence[str]]
) -> dict[Key, np.ndarray]:
    """Return births, deaths by cause and energy flows from columns of the series that were summed over ticks:
    f[ticks, species]. `foods` lists the foods of each species."""
    out: dict[Key, np.ndarray] = {}
    for s, name in enumerate(species):
        causes = ((c.removeprefix(DIED), of[:, s]) for c, of in totals.items() if c.startswith(DIED))
        out |= died(name, [(c, of) for c, of in causes if of[-1]], totals["births"][:, s])
    since = {name: np.vstack([0 * of[:1], of]) for name, of in totals.items()}
    return out | {key: of[1:] for key, of in flows.of_run(since, species, foods).items()}


def _journal(journal: Journal, causes: Sequence[str], species: Sequence[str]) -> dict[Key, float]:
    out: dict[Key, float] = {}
    for s, name in enumerate(species):
        of = [(("unknown", *causes)[c], float(journal.died[s][c])) for c in np.flatnonzero(journal.died[s])]
        out |= died(name, of, float(journal.born[s]))
    return out


def _state(world: World, species: Sequence[str]) -> dict[Key, np.ndarray]:
    """Return the population sizes, and after the first tick the mean happiness, energy flows and reports."""
    out: dict[Key, Any] = {}
    for name in species:
        table = world.tables[name]
        rows, out["n", name] = table.rows(), table.n
        if world.tick and table.n and _feels(world, name):
            out["happiness", name] = table[Nervous].happiness[rows].mean(dtype=np.float64)
        if world.tick and table.n and world.space.volume and Velocity in table:
            height = table[Position].z[rows].mean(dtype=np.float64) - float(world.space.size[2])
            out["reports", DEPTH, name] = height
        if world.tick and table.n and Metabolism in table:
            for words, of in zip(
                flows.ENERGY, (table[Metabolism].taken, table[Metabolism].burnt), strict=True
            ):
                out["energy", name, words] = of[rows].sum(dtype=np.float64)
    for name in world.reporters if world.tick else ():
        said = world.measure(name)
        for of, value in (said if isinstance(said, dict) else {"": said}).items():
            out["reports", name, of] = value
    return {key: np.array([value], float) for key, value in out.items()}


def _reports(world: World, rows: Mapping[str, np.ndarray], species: Sequence[str]) -> dict[Key, np.ndarray]:
    latest = {} if world.recorder is None or world.recorder.reports is None else world.recorder.reports.latest
    out: dict[Key, np.ndarray] = {}
    for name, said in latest.items():
        of_species = [s for s in species if s in said] if isinstance(said, dict) else [""]
        for s in of_species:
            out["reports", name, s] = rows[name][:, species.index(s) if s else 0]
    return out


def _feels(world: World, name: str) -> bool:
    table = world.tables[name]
    return Nervous in table and table.species.nerves.happiness is not None


def _genes(world: World, genes: Mapping[str, Collection[str]]) -> dict[Key, float]:
    """Return the mean values of genes among living organisms."""
    out: dict[Key, float] = {}
    for name, of in genes.items():
        table = world.tables[name]
        if of and table.n:
            decoded = table.species.heredity.layout.decode(table[Genome].loci[table.rows()], list(of))
            out |= {
                ("genes", f"{name}.{gene}"): float(values.mean(dtype=np.float64))
                for gene, values in decoded.items()
            }
    return out
