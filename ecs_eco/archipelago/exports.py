"""Migrants in files: what an island sends at a barrier, which its neighbours read."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.engine.errors import CheckpointError, ForeignFile
from ecs_eco.life.migration import Migrants, copied
from ecs_eco.record import checkpoint
from ecs_eco.record.archipelago import ISLANDS
from ecs_eco.record.container import inside

FOLDER = "exports"
OWN = {"uid": np.dtype(np.uint64), "born": np.dtype(np.int64), "to": np.dtype(np.int64)}


def write(path: Path, archipelago: str, world: Any) -> dict[str, dict[str, int]]:
    """Write the migrants that leave an island before its next tick, into its run folder, with the hash of
    their archipelago; return how many go where: species → island → number."""
    islands = world.config.archipelago
    leaving = copied(world)
    arrays: dict[str, np.ndarray] = {}
    for species, migrants in leaving.items():
        arrays |= {
            f"{species}/uid": migrants.uid,
            f"{species}/born": migrants.born,
            f"{species}/to": migrants.to,
        }
        arrays |= {f"{species}/columns/{name}": column for name, column in migrants.columns.items()}
    meta = {
        "archipelago": archipelago,
        "island": islands.here,
        "tick": world.tick,
        "seed": world.seed,
        "species": list(leaving),
    }
    checkpoint.write(path / FOLDER / checkpoint.name_of(world.tick), meta, arrays)
    return {
        species: {islands.names[to]: int((migrants.to == to).sum()) for to in np.unique(migrants.to)}
        for species, migrants in leaving.items()
    }


def of_neighbours(
    root: Path, archipelago: str, world: Any, tick: int
) -> Iterator[tuple[int, dict[str, Migrants]]]:
    """Yield what each island that sends migrants here wrote at a barrier, in the order of their numbers.

    Raises CheckpointError for a file that is missing or damaged, ForeignFile for that of another archipelago,
    island or barrier.
    """
    islands = world.config.archipelago
    for number, targets in enumerate(islands.neighbours()):
        if islands.number in targets:
            name = islands.names[number]
            file = root / ISLANDS / name / FOLDER / checkpoint.name_of(tick)
            yield (
                number,
                read(
                    inside(root, file),
                    {"archipelago": archipelago, "island": name, "tick": tick},
                    list(islands.emigration),
                ),
            )


def read(file: Path, wanted: dict[str, Any], wander: list[str]) -> dict[str, Migrants]:
    """Return the migrants that an island sent at a barrier, by species."""
    meta, arrays = checkpoint.read(file)
    if different := [key for key, value in wanted.items() if meta.get(key) != value]:
        raise ForeignFile(f"{file}: has migrants of another {', '.join(different)}")
    groups: dict[str, dict[str, np.ndarray]] = {}
    for key, array in arrays.items():
        species, _, name = key.partition("/")
        if species not in wander or array.ndim < 1 or array.dtype != OWN.get(name, array.dtype):
            raise CheckpointError(f"{file}: {key}: is not what an island sends")
        groups.setdefault(species, {})[name.removeprefix("columns/")] = array
    out = {}
    for species, group in groups.items():
        if not OWN.keys() <= group.keys() or len(set(map(len, group.values()))) > 1:
            raise CheckpointError(f"{file}: {species}: columns are missing, or differ in length")
        uid, born, to = (group.pop(name) for name in OWN)
        out[species] = Migrants(uid, born, to, group)
    return out
