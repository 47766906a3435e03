"""Migrants in files: what an island sends at a barrier, which its neighbours read."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.checkpoint import file as checkpoint
from ecs_eco.lifecycle.migration import Migrants, copied
from ecs_eco.record.archipelago import ISLANDS

FOLDER = "exports"


def write(path: Path, world: Any) -> dict[str, dict[str, int]]:
    """Write the migrants that leave an island before its next tick, into its run folder; return how many go
    where: species → island → number."""
    islands = world.config.archipelago
    leaving = copied(world)
    arrays: dict[str, np.ndarray] = {}
    for species, migrants in leaving.items():
        arrays |= {f"{species}/uid": migrants.uid, f"{species}/born": migrants.born,
                   f"{species}/to": migrants.to}
        arrays |= {f"{species}/columns/{name}": column for name, column in migrants.columns.items()}
    meta = {"island": islands.here, "tick": world.tick, "seed": world.seed, "species": list(leaving)}
    checkpoint.write(path / FOLDER / checkpoint.name_of(world.tick), meta, arrays)
    return {species: {islands.names[to]: int((migrants.to == to).sum()) for to in np.unique(migrants.to)}
            for species, migrants in leaving.items()}


def of_neighbours(root: Path, islands: Any, tick: int) -> Iterator[tuple[int, dict[str, Migrants]]]:
    """Yield what each island that sends migrants here wrote at a barrier, in the order of their numbers.

    Raises CheckpointError for a file that is missing or damaged.
    """
    for number, targets in enumerate(islands.neighbours()):
        if islands.number in targets:
            yield number, read(root / ISLANDS / islands.names[number], tick)


def read(path: Path, tick: int) -> dict[str, Migrants]:
    """Return the migrants that an island sent at a barrier, by species."""
    meta, arrays = checkpoint.read(path / FOLDER / checkpoint.name_of(tick))
    out = {}
    for species in meta["species"]:
        start = f"{species}/columns/"
        columns = {name.removeprefix(start): array for name, array in arrays.items()
                   if name.startswith(start)}
        uid, born, to = (arrays[f"{species}/{word}"] for word in ("uid", "born", "to"))
        out[species] = Migrants(uid, born, to, columns)
    return out
