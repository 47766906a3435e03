"""Conformance check for a world."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.debug import DebugError
from ecs_eco.debug.invariants import Invariants
from ecs_eco.ecosystem import World
from ecs_eco.engine.table import Table
from ecs_eco.record import matter
from ecs_eco.record.ledger import LEDGER, imbalance
from ecs_eco.testing.states import all_threads, difference, shuffle, state
from ecs_eco.testing.stores import Stores


def check_world(world: Any, ticks: int = 30) -> None:
    """Check a world over a number of ticks.

    In every tick, uids must be unique, dead organisms must stay dead, all values must be finite and within
    bounds, and the ledgers of energy, matter and numbers must close. The same seed must give the same
    results, even with two threads or a different row order.

    Parameters
    ----------
    world : str, Path, Mapping, WorldConfig or callable
        Anything that `World.from_config` accepts, or a function of the number of threads that returns a new
        world.
    ticks : int, default 30

    Raises
    ------
    AssertionError
        If a check fails.

    Examples
    --------
    >>> from ecs_eco.testing import check_world
    >>> check_world("reflexes", ticks=3)
    """
    make = world if callable(world) else lambda threads: World.from_config(world, threads=threads)
    lives: list[tuple] = []
    lives_too: list[tuple] = []
    first = make(1)
    note(first, lives)
    watch(first, ticks)
    if make(1).run(ticks).digest() != first.digest():
        raise AssertionError(
            f"{first.name}: the same seed gives a different world; draw random numbers with "
            "ecs_eco.draw, and keep no state outside the world"
        )
    with all_threads():
        threaded = make(2).run(ticks)
    if threaded.digest() != first.digest():
        changed = difference(state(first), state(threaded)) or "networks or fields differ"
        raise AssertionError(f"{first.name}: two threads give a different world: {changed}")
    shuffled = shuffle(make(1))
    note(shuffled, lives_too)
    shuffled.run(ticks)
    if changed := difference(state(first), state(shuffled)):
        raise AssertionError(f"{first.name}: a different row order gives different results: {changed}")
    if lives != lives_too:
        a, b = next((a, b) for a, b in zip([*lives, None], [*lives_too, None], strict=False) if a != b)
        raise AssertionError(
            f"{first.name}: a different row order gives different births and deaths: {a} and {b}"
        )


def note(world: World, lives: list[tuple]) -> None:
    """Append every birth and death to `lives`."""

    def born(table: Table, rows: np.ndarray, parents: np.ndarray, second: np.ndarray) -> None:
        lives.extend(
            (world.tick, table.name, *pair)
            for pair in zip(table.uid[rows].tolist(), parents.tolist(), strict=True)
        )

    def died(table: Table, rows: np.ndarray) -> None:
        for r in rows:
            cause = world.causes[table.cause[r] - 1]
            lives.append((world.tick, table.name, int(table.uid[r]), cause, int(table.killer[r])))

    world.on_birth.append(born)
    world.on_death.append(died)


def watch(world: World, ticks: int) -> None:
    """Run a world tick by tick, and check its invariants after each tick.

    Parameters
    ----------
    world : World
    ticks : int

    Raises
    ------
    AssertionError
        If a check fails.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.testing import watch
    >>> watch(World.from_config("reflexes", seed=1), ticks=3)
    """
    dead: set[int] = set()
    world.on_death.append(lambda table, rows: dead.update(table.uid[rows].tolist()))
    stores, invariants = Stores(world), Invariants(world, world.name)
    for _ in range(ticks):
        world.run(1)
        stores.note()
        _check_dead(world, dead)
        try:
            invariants.check_organisms()
        except DebugError as error:
            raise AssertionError(str(error)) from error
    if world.recorder is not None:
        _check_books(world)


def _check_dead(world: World, dead: set[int]) -> None:
    """Check that dead organisms stay dead, and that no death is pending between ticks."""
    where = f"{world.name}, tick {world.tick}"
    for table in world.tables.values():
        if risen := dead.intersection(table.uid[table.rows()].tolist()):
            raise AssertionError(f"{where}: uids {sorted(risen)[:5]} have died but are alive")
        if table.cause.any():
            raise AssertionError(f"{where}: table {table.name!r} contains causes of death after the tick")


def _check_matter(world: World) -> None:
    """Check that the matter ledger closes to within 1e-6 of the stock."""
    pages = {name: np.array(values) for name, values in world.recorder.matter_series().to_pydict().items()}
    off, size = np.abs(matter.imbalance(pages)), np.sum([np.abs(pages[c]) for c in matter.LEDGER], axis=0)
    if (wrong := np.flatnonzero(off > 1e-6 * size + 1e-15)).size:
        i = wrong[0]
        raise AssertionError(
            f"{world.name}, tick {pages['tick'][i]}: the ledger of {pages['substance'][i]} "
            f"in {pages['holder'][i]} is off by {off[i]:g} mol; a system that changes "
            "concentrations must record the change with ecs_eco.life.matter.booked"
        )


def _check_books(world: World) -> None:
    """Check that the recorded series balances: energy within float tolerance, numbers exactly."""
    series = world.series().to_pydict()
    ledger = {name: np.array(series[name]) for name in LEDGER}
    off = np.abs(imbalance(ledger))
    size = np.sum([np.abs(column) for column in ledger.values()], axis=0)
    if (wrong := np.flatnonzero(off > 1e-6 * size + 1e-12)).size:
        i = wrong[0]
        page = ", ".join(f"{name} {column[i]:g}" for name, column in ledger.items())
        where = f"{world.name}, tick {series['tick'][i]}, {series['species'][i]}"
        raise AssertionError(f"{where}: the energy ledger is off by {off[i]:g}: {page}")
    if world.recorder.matter is not None:
        _check_matter(world)
    s = len(world.recorder.names)
    n, births, deaths = (np.array(series[k]).reshape(-1, s) for k in ("n", "births", "deaths"))
    if (np.diff(n, axis=0) != (births - deaths)[1:]).any():
        raise AssertionError(f"{world.name}: the changes in numbers differ from births − deaths")
    causes = np.sum([v for k, v in series.items() if k.startswith("died: ")], axis=0)
    if (causes != np.array(series["deaths"])).any():
        raise AssertionError(f"{world.name}: the deaths by cause do not add up to the total")
