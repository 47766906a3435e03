"""Migration between islands: the choice of migrants, their data, and their arrival.

Migrants are chosen between two ticks, depending only on (seed, tick, uid). The new island receives copies of
the emigrants' columns; only positions are new. Migration counts as neither death nor birth.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco._lazy import stored_name
from ecs_eco.components import Position
from ecs_eco.engine import random
from ecs_eco.engine.errors import CheckpointError
from ecs_eco.engine.turnover import arrive, depart
from ecs_eco.life.founders import scatter

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld


class Migrants(NamedTuple):
    """Migrants of one species, in uid order."""

    uid: np.ndarray  # u64[k]
    born: np.ndarray  # i64[k], the tick of birth
    to: np.ndarray  # i64[k], the number of the destination island
    columns: dict[str, np.ndarray]  # "Component.field" → [k, …]


def emigrants(world: SpatialWorld) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the organisms that emigrate from this island before the next tick: species → rows i64[k] in uid
    order, and numbers of the destination islands i64[k]."""
    plan = world.config.archipelago
    targets = np.array(plan.neighbours()[plan.number], np.int64)
    out = {}
    for name, chance in plan.migration_probability.items() if targets.size and plan.meets(world.tick) else ():
        table = world.tables[name]
        rows = table.by_uid()
        rows = rows[table.cause[rows] == 0]
        rows = rows[random.draw_many(world.key, table.uid[rows], random.MIGRATE) < chance]
        if rows.size:
            where = random.draw_many(world.key, table.uid[rows], random.MIGRATE + (1 << 8))
            out[name] = rows, targets[(where * np.float32(targets.size)).astype(np.int64)]
    return out


def copied(world: SpatialWorld) -> dict[str, Migrants]:
    """Return copies of the organisms that emigrate before the next tick, by species; the world does not
    change.

    Raises a RuntimeError for an emigrant whose esper entity has a plain component, that is, one not stored in
    columns.
    """
    leaving = emigrants(world)
    for name, (rows, _) in leaving.items():
        _refuse_plain(world, world.tables[name], rows)
    return {
        name: Migrants(
            world.tables[name].uid[rows],
            world.tables[name].born[rows],
            to,
            _columns(world.tables[name], rows),
        )
        for name, (rows, to) in leaving.items()
    }


def leave(world: SpatialWorld) -> None:
    """Remove the organisms that emigrate before the next tick."""
    for name, (rows, to) in emigrants(world).items():
        table = world.tables[name]
        nerves = table.species.nerves
        if nerves is not None and nerves.learning:
            nerves.leave(rows)
        depart(world, table, rows, to)


def admit(world: SpatialWorld, groups: Iterable[tuple[int, Mapping[str, Migrants]]]) -> None:
    """Add migrants at random positions, given as (number of the island of origin, species → migrants),
    ordered by this number and then by uid. Migrants to other islands are left out.

    Raises a CheckpointError for migrants whose columns differ from this island's columns.
    """
    here = world.config.archipelago.number
    for origin, species in groups:
        for name, all_ in species.items():
            mine = all_.to == here
            if mine.any():
                uid = all_.uid[mine]
                values = _values(world.tables[name], {key: v[mine] for key, v in all_.columns.items()})
                places = scatter(world.tables[name], world, uid)
                values |= {(Position, axis): places[Position, axis] for axis in "xyz"}
                arrive(
                    world,
                    world.tables[name],
                    uid,
                    all_.born[mine],
                    values,
                    np.full(uid.size, origin, np.int64),
                )


def _columns(table: Table, rows: np.ndarray) -> dict[str, np.ndarray]:
    """Return copies of all columns for some rows."""
    return {
        f"{stored_name(component)}.{field}": np.array(array[rows])
        for component, held in table.columns.items()
        for field, array in vars(held).items()
    }


def _values(table: Table, columns: Mapping[str, np.ndarray]) -> dict[tuple[type, str], np.ndarray]:
    """Return the columns by component and field."""
    known = {
        f"{stored_name(component)}.{field}": (component, field, array)
        for component, held in table.columns.items()
        for field, array in vars(held).items()
    }
    for name in {**known, **columns}:
        mine, theirs = (
            [] if array is None else [array.dtype.str, list(array.shape[1:])]
            for array in (known[name][2] if name in known else None, columns.get(name))
        )
        if mine != theirs:
            raise CheckpointError(
                f"{table.name}: migrants have {name} as {theirs or 'no column'}, but this island has it as "
                f"{mine or 'no column'}; a migrating species needs the same columns on all islands"
            )
    return {known[name][:2]: values for name, values in columns.items()}


def _refuse_plain(world: SpatialWorld, table: Table, rows: np.ndarray) -> None:
    for uid, thing in world.context.registry.plain(table, rows):
        raise RuntimeError(
            f"organism {uid} of {table.name!r} has a plain "
            f"{type(thing).__name__}, which cannot migrate to another island; declare it with @component, "
            "and name it in `components`"
        )
