"""Assemble the whole world in process 0 from the parts of all processes."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from ecs_eco.bands.fields import complete
from ecs_eco.bands.rollout import last_of
from ecs_eco.engine.uids import matched
from ecs_eco.learning.rollout import Rollout
from ecs_eco.record import freeze as frozen

Arrays = dict[str, np.ndarray]


def gather(bands: Any) -> Any:
    """In process 0, return a separate world with the organisms of all processes; elsewhere, return None.

    It equals the world of a single-process run except for row order, which affects neither its digest
    nor its future.
    """
    world = bands.world
    complete(bands.fields, bands.wire)
    logs = {name: rollout.gathered() for name, rollout in bands.rollouts.items()}
    meta, arrays = frozen.parts_of(world)
    own = {key: array for key, array in arrays.items() if _of_organisms(key)}
    parts = bands.wire.comm.gather(own)
    if parts is None:
        return None
    for name, table in world.tables.items():
        prefix = f"table/{name}/"
        keys = [key for key in own if key.startswith(prefix)]
        order = np.argsort(np.concatenate([part[f"{prefix}uid"] for part in parts]))
        for key in keys:
            arrays[key] = np.concatenate([part[key] for part in parts])[order]
        arrays[f"{prefix}row"] = np.arange(order.size)
        meta["tables"][name]["capacity"] = max(table.capacity, order.size)
        if name in logs:
            lives, columns = logs[name]
            _log(
                arrays,
                f"{prefix}trait/nerves/learner.rollout.",
                bands.rollouts[name],
                lives,
                columns,
                arrays[f"{prefix}uid"],
            )
    where = f"the whole world {world.name!r}"
    meta = json.loads(json.dumps(meta))
    whole = frozen.thaw(world.__class__, meta, world.threads, world.config, (), where)
    frozen.load(whole, meta, {key: array.copy() for key, array in arrays.items()}, where)
    return whole


def _of_organisms(key: str) -> bool:
    """Return whether an array of a frozen world has one row for each living member of a table."""
    parts = key.split("/")
    return parts[0] == "table" and len(parts) == 3


def _log(
    arrays: Arrays, prefix: str, mine: Rollout, lives: np.ndarray, columns: list[np.ndarray], uid: np.ndarray
) -> None:
    """Insert the rollout of all processes into a frozen world whose row i is organism uid[i] u64[n]."""
    at, living = matched(uid, lives)
    rows = np.where(living, at, uid.size + np.cumsum(~living) - 1)  # a separate row for each dead organism
    whole = Rollout(
        columns[0].shape[1], columns[1].shape[1], mine.discount, columns[3].shape[1], columns[2].shape[1]
    )
    whole._hold(columns[:6])
    whole.n, whole.ticks = len(columns[5]), mine.ticks
    whole.steps["row"] = rows[whole.steps["row"]]
    whole.last = last_of(whole.steps["row"], whole.ended, uid.size + int((~living).sum()))
    arrays |= {prefix + name: array for name, array in whole.state().items()}
