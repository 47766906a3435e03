"""Conformance check for a system: the rules that make results independent of row order, threads and process."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np
from esper import Processor

from ecs_eco.components import Position
from ecs_eco.debug import Debug, DebugError
from ecs_eco.debug.columns import IDENTITY, columns
from ecs_eco.ecosystem import World
from ecs_eco.engine.phases import PHASES
from ecs_eco.engine.schema import Handle
from ecs_eco.engine.system import System
from ecs_eco.testing.states import State, all_threads, difference, shuffle, state


def check_system(kind: type[System], make_world: Callable[[int], Any], ticks: int = 5) -> None:
    """Check a system in identical new worlds.

    It must be declared completely, and leave births and deaths to `request` and `kill`. It must keep columns
    and their types, write only to living organisms, keep their values finite and within bounds, add 1 to
    `table.version` if it moves any, and record the energy that it gives and takes in the flow columns. It must
    not use global random numbers, and must give the same results for any row order and number of threads.

    Parameters
    ----------
    kind : type
        Class of the system.
    make_world : callable
        Called as `make_world(threads)`; returns a new world that has a system of this class.
    ticks : int, default 5

    Raises
    ------
    AssertionError
        If a check fails.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.systems import Metabolise
    >>> from ecs_eco.testing import check_system
    >>> check_system(Metabolise, lambda threads: World.from_config("reflexes", seed=1, threads=threads))
    """
    _check_declaration(kind)
    alone = _followed(kind, make_world(1), ticks)
    with all_threads():
        _same(kind, alone, _followed(kind, make_world(2), ticks), "with two threads")
    _same(kind, alone, _followed(kind, shuffle(make_world(1)), ticks), "with a different row order")
    _watch(make_world(1), ticks)


def _check_declaration(kind: type[System]) -> None:
    if not (isinstance(kind, type) and issubclass(kind, System)):
        raise AssertionError(f"{kind!r} is not a class derived from ecs_eco.System")
    name = kind.__name__
    if not (kind.__dict__.get("__doc__") or "").strip():
        raise AssertionError(
            f"{name}: add a docstring that describes what the system does to which organisms"
        )
    if kind.phase not in PHASES:
        raise AssertionError(f"{name}: the phase is {kind.phase!r}; expected one of {', '.join(PHASES)}")
    wrong = [c for c in kind.needs if not (isinstance(c, type) and issubclass(c, Handle) and c.fields)]
    if wrong:
        raise AssertionError(f"{name}: needs names {wrong[0]!r}, which is not a component")
    if kind.update is System.update and kind.process is System.process:
        raise AssertionError(f"{name}: it must define update(table, world) or process()")


def _watch(world: World, ticks: int) -> None:
    """Run a world with the checks of debug mode, regardless of the environment."""
    if world.debug is None:
        world.debug = Debug(world)
    try:
        world.run(ticks)
    except DebugError as error:
        raise AssertionError(str(error)) from error


def _followed(kind: type[System], world: World, ticks: int) -> list[tuple[State, State]]:
    """Run a world and check the system; return the states before and after each run of the system."""
    system = next((s for s in world.systems if type(s) is kind), None)
    if system is None:
        raise AssertionError(f"{kind.__name__}: make_world builds a world without this system; add it")
    probe = Probe(kind, world, system)
    world.schedule[world.schedule.index(system)] = probe
    world.run(ticks)
    return probe.seen


class Probe(Processor):
    """Replaces a system in the schedule; runs it, and stores the states before and after."""

    def __init__(self, kind: type[System], world: World, system: System) -> None:
        self.kind, self.world, self.system, self.priority = kind, world, system, system.priority
        self.seen: list[tuple[State, State]] = []

    def process(self, *_: object) -> None:
        """Run the system, and check its changes."""
        kind, world = self.kind, self.world
        before, shape, chance = state(world), _shape(world), _global_chance()
        versions = {t.name: t.version for t in world.tables.values()}
        self.system.process()
        after = state(world)
        if _global_chance() != chance:
            raise AssertionError(
                f"{kind.__name__}: it uses global random numbers; "
                "use ecs_eco.engine.random.draw(world.key, uid, purpose)"
            )
        for part, value in _shape(world).items():
            if value != shape[part]:
                raise AssertionError(
                    f"{kind.__name__}: it changes {part}; "
                    "use table.request and world.kill, and write to columns"
                )
        _check_values(kind, world, before, after, versions)
        self.seen.append((before, after))


def _shape(world: World) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for table in world.tables.values():
        identity = [getattr(table, name).tobytes() for name in IDENTITY]
        out[f"the organisms in {table.name!r}"] = (table.n, table.high, *identity)
        for component, name, array in columns(table):
            out[f"the type of {component.__name__}.{name}"] = (array.dtype, array.shape)
    return out


def _global_chance() -> Any:
    return str(np.random.get_state()), random.getstate()  # noqa: NPY002


def _check_values(
    kind: type[System], world: World, before: State, after: State, versions: dict[str, int]
) -> None:
    lengths = dict(zip("xyz", (*world.space.size, np.inf), strict=False))
    for name, now in after.items():
        for column, values in now.items():
            where = f"{kind.__name__}: {column} in table {name!r}"
            if values.dtype.kind == "f" and not np.isfinite(values).all():
                raise AssertionError(
                    f"{where} has become {values[~np.isfinite(values)][0]}; expected a finite value"
                )
        table = world.tables[name]
        if (now["cause"] > len(world.causes)).any():
            raise AssertionError(
                f"{kind.__name__}: a cause of death in table {name!r} is unknown; "
                "get its code from world.cause(name)"
            )
        if Position in table:
            for axis, length in lengths.items():
                place, was = now[f"Position.{axis}"], before[name][f"Position.{axis}"]
                if ((place < 0) | (place >= length)).any():
                    where = f"{kind.__name__}: Position.{axis} in table {name!r}"
                    raise AssertionError(
                        f"{where} leaves [0, {length}); bring it back with ecs_eco.space.geometry.into"
                    )
                if table.version == versions[name] and not np.array_equal(place, was):
                    raise AssertionError(
                        f"{kind.__name__}: it moves {name!r} without marking the table; add `table.version += 1`"
                    )


def _same(
    kind: type[System], one: list[tuple[State, State]], other: list[tuple[State, State]], how: str
) -> None:
    for tick, ((before, after), (before_too, after_too)) in enumerate(zip(one, other, strict=True)):
        if changed := difference(before, before_too):
            raise AssertionError(
                f"tick {tick}: before {kind.__name__} runs, {how}, {changed}; another system is the cause"
            )
        if changed := difference(after, after_too):
            raise AssertionError(f"{kind.__name__}: its results change {how}: tick {tick}, {changed}")
