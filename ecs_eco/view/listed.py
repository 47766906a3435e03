"""What a table of organisms lists of each: uid, birth, founder, energy, happiness, age, place, genes."""

from __future__ import annotations

from typing import Any

from ecs_eco.components import Position
from ecs_eco.view.listing import Columns

STATES = ("energy", "happiness", "age")


def living(live: Any, name: str) -> Columns:
    """Return the columns of a species of a `Live` world, in the order of uids."""
    table = live.world.tables[name]
    rows, p = table.by_uid(), table[Position]
    uid = table.uid[rows]
    out = {"uid": uid, "born": table.born[rows], "family": live.families.roots(uid)}
    for key in (*STATES, *(f"gene:{gene}" for gene in live.genes[name])):
        column = live.column(table, key)[0]
        if column is not None:
            out[key] = column[rows]
    places: Columns = {axis: getattr(p, axis)[rows] for axis in ("xyz" if live.world.space.volume else "xy")}
    return out | places


def recorded(replay: Any, name: str) -> Columns:
    """Return the columns of a species at the tick of a `Replay`, in the order of uids."""
    r, organisms = replay.recording, replay.organisms(name)
    uid = organisms.uid
    out = {"uid": uid, "born": r.born(uid), "family": replay.families.roots(uid)}
    for key in (*STATES, *(f"gene:{gene}" for gene in replay.genes.codes.get(name, ()))):
        column = replay.column(name, organisms, key)[0]
        if column is not None:
            out[key] = column
    places: Columns = {axis: getattr(organisms, axis) for axis in "xyz"[: len(r.size)]}
    return out | places
