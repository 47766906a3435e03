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
    """Return copies of all columns of all tables, sorted by uid.

    Parameters
    ----------
    world : World

    Returns
    -------
    dict of str to dict of str to array
        The columns, by table and then by name: "uid", "Position.x" and so on.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.testing import state
    >>> state(World.from_config("predator-prey", seed=1))["deer"]["uid"].shape
    (700,)
    """
    out: State = {}
    for table in world.tables.values():
        rows = table.by_uid()
        out[table.name] = {name: getattr(table, name)[rows] for name in ("uid", "born", "cause", "killer")}
        for component, held in table.columns.items():
            for name, array in sorted(vars(held).items()):
                out[table.name][f"{component.__name__}.{name}"] = array[rows]
    return out


def difference(one: State, other: State) -> str:
    """Return a description of the first difference between two states.

    Parameters
    ----------
    one, other : dict
        As returned by `state`.

    Returns
    -------
    str
        Empty if all bytes are equal.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.testing import difference, state
    >>> world = World.from_config("predator-prey", seed=1)
    >>> difference(state(world), state(world.copy()))
    ''
    """
    for table, columns in one.items():
        mine, theirs = columns["uid"], other[table]["uid"]
        if mine.tobytes() != theirs.tobytes():
            only, only_there = (np.setdiff1d(*both)[:5].tolist() for both in ((mine, theirs), (theirs, mine)))
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
    """Permute the rows of every table at random, which must not change any result.

    Parameters
    ----------
    world : World
    seed : int, default 0

    Returns
    -------
    World
        The same world.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.testing import shuffle
    >>> world = World.from_config("predator-prey", seed=1)
    >>> before = world.digest()
    >>> shuffle(world).digest() == before
    True
    """
    generator = np.random.Generator(np.random.Philox(seed))
    for table in world.tables.values():
        table.reorder(generator.permutation(table.rows()))
    return world


def arrange(world: World, name: str, **fields: Any) -> Any:
    """Set fields of all living members of a table, and return the table.

    Parameters
    ----------
    world : World
    name : str
        Name of the table.
    **fields
        Fields by name: a single value, or a value for each organism, in order of uid.

    Returns
    -------
    Table

    Raises
    ------
    UnknownName
        If no component of the table has the field.
    ValueError
        If the number of values does not match.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.components import Metabolism, Position
    >>> from ecs_eco.testing import arrange
    >>> world = World((10.0, 10.0))
    >>> hares = world.add_table("hare", Position, Metabolism)
    >>> world.spawn("hare", n=2)
    >>> world.flush()
    >>> arrange(world, "hare", x=[1.0, 2.0], energy=0.5)[Position].x[:2].tolist()
    [1.0, 2.0]
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
    """Run one system of a world once, outside of any tick.

    Births and deaths that it requests take effect with `world.flush()`.

    Parameters
    ----------
    world : World
    kind : type
        Class of the system.

    Raises
    ------
    UnknownName
        If the world has no system of this class.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.components import Metabolism
    >>> from ecs_eco.systems import Metabolise
    >>> from ecs_eco.testing import act
    >>> world = World.from_config("predator-prey", seed=1)
    >>> before = world.table("deer")[Metabolism].energy.sum()
    >>> act(world, Metabolise)
    >>> bool(world.table("deer")[Metabolism].energy.sum() < before)
    True
    """
    systems = [s for s in world.systems if type(s) is kind]
    if not systems:
        raise UnknownName(
            unknown_name("world", "system", kind.__name__, [type(s).__name__ for s in world.systems])
        )
    with world:
        world._act(systems[:1])


@contextmanager
def all_threads() -> Iterator[None]:
    """Return a context in which worlds use all their threads, even with few organisms.

    Returns
    -------
    context manager

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.testing import all_threads
    >>> with all_threads():
    ...     World.from_config("predator-prey", seed=1, threads=2).run(1).tick
    1
    """
    before, workers.PARALLEL_FROM = workers.PARALLEL_FROM, 0
    try:
        yield
    finally:
        workers.PARALLEL_FROM = before
