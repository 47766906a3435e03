"""The state of a world by uid, and helpers that set it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from ecs_eco.compiled import workers
from ecs_eco.ecosystem import World
from ecs_eco.engine.errors import UnknownName, unknown_name
from ecs_eco.engine.system import System

State = dict[str, dict[str, np.ndarray]]


def state(world: World) -> State:
    """Return copies of all columns of all tables, ordered by uid: {table: {"uid": …, "Position.x": …}}."""
    out: State = {}
    for table in world.tables.values():
        rows = table.by_uid()
        out[table.name] = {name: getattr(table, name)[rows] for name in ("uid", "born", "cause", "killer")}
        for component, columns in table.columns.items():
            out[table.name] |= {
                f"{component.__name__}.{name}": array[rows] for name, array in sorted(vars(columns).items())
            }
    return out


def difference(one: State, other: State) -> str:
    """Return the first difference between two states, "" if they are bitwise equal."""
    for table, columns in one.items():
        mine, theirs = columns["uid"], other[table]["uid"]
        if mine.tobytes() != theirs.tobytes():
            only, only_there = (
                np.setdiff1d(mine, theirs)[:5].tolist(),
                np.setdiff1d(theirs, mine)[:5].tolist(),
            )
            return f"{table}: uids {only} are only in one, {only_there} only in the other"
        for name, array in columns.items():
            if array.tobytes() != other[table][name].tobytes():
                rows = [i for i in range(len(mine)) if array[i].tobytes() != other[table][name][i].tobytes()]
                i = rows[0]
                return (
                    f"{table}: {name} of uid {mine[i]} is {array[i]!r} in one and "
                    f"{other[table][name][i]!r} in the other ({len(rows)} of {len(mine)} differ)"
                )
    return ""


def shuffle(world: World, seed: int = 0) -> Any:
    """Permute the rows of the living in every table at random, which must not change any result; return the
    world."""
    generator = np.random.Generator(np.random.Philox(seed))
    for table in world.tables.values():
        table.reorder(generator.permutation(table.rows()))
    return world


def arrange(world: World, name: str, **fields: Any) -> Any:
    """Set fields of all living members of a kind, by name, to one value or to one value each in the order of
    uids; return the table.

    Raises KeyError for a field that no component of the table has, ValueError for a wrong number of values.
    """
    table = world.table(name)
    rows = table.by_uid()
    for field, value in fields.items():
        owner = next((c for c in table.columns if field in c.fields), None)
        if owner is None:
            known = [f for c in table.columns for f in c.fields]
            raise UnknownName(unknown_name(f"table {name!r}", "field", field, known))
        column = table.field(owner, field)
        column[rows] = np.broadcast_to(np.asarray(value, column.dtype), column[rows].shape)
    table.version += 1
    return table


def act(world: World, kind: type[System]) -> None:
    """Run the world's system of one kind once, outside of any tick; births and deaths wait for
    `world.flush()`."""
    systems = [s for s in world.systems if type(s) is kind]
    if not systems:
        raise UnknownName(
            unknown_name("world", "system", kind.__name__, [type(s).__name__ for s in world.systems])
        )
    with world:
        world.act(systems[:1])


@contextmanager
def all_threads() -> Iterator[None]:
    """Make worlds use all their threads within this block, even with few organisms."""
    before, workers.PARALLEL_FROM = workers.PARALLEL_FROM, 0
    try:
        yield
    finally:
        workers.PARALLEL_FROM = before
