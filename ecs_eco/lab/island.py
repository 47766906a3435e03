"""Run one island from one barrier to the next. Repeating this task gives the same result on any machine."""

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.analysis.report import write_report
from ecs_eco.config import WorldConfig
from ecs_eco.config.loading import island_of
from ecs_eco.ecosystem import World
from ecs_eco.engine.errors import CheckpointError, ForeignFile
from ecs_eco.lab.pool import finishing, once_free
from ecs_eco.life.migration import Migrants, admit, copied, leave
from ecs_eco.record import checkpoint, container
from ecs_eco.record.archipelago import FILE, ISLANDS, Manifest, check_island, read
from ecs_eco.record.claim import Claim, claim_new
from ecs_eco.record.code import recorded
from ecs_eco.runs.begin import begin, begun, keep_manifest
from ecs_eco.runs.run import built, go_on, manifest_of, read_manifest, restored, snapshots
from ecs_eco.worlds.policies import weights_files

FOLDER = "exports"
OWN = {"uid": np.dtype(np.uint64), "born": np.dtype(np.int64), "to": np.dtype(np.int64)}


def write_migrants(path: Path, archipelago: str, world: World) -> dict[str, dict[str, int]]:
    """Write the migrants that leave before the next tick; return their numbers: species → island → number."""
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


def arrivals(
    root: Path, archipelago: str, world: World, tick: int
) -> Iterator[tuple[int, dict[str, Migrants]]]:
    """Yield the migrants that other islands sent here at a barrier, in order of island number. Raises
    CheckpointError if a file is missing or damaged, ForeignFile if it is from elsewhere."""
    islands = world.config.archipelago
    for number, targets in enumerate(islands.neighbours()):
        if islands.number in targets:
            name = islands.names[number]
            yield (
                number,
                read_migrants(
                    container.inside(root, root / ISLANDS / name / FOLDER / checkpoint.name_of(tick)),
                    {"archipelago": archipelago, "island": name, "tick": tick},
                    list(islands.migration_probability),
                ),
            )


def read_migrants(file: Path, wanted: dict[str, Any], wander: list[str]) -> dict[str, Migrants]:
    """Read the migrants that an island sent at a barrier, by species."""
    meta, arrays = checkpoint.read(file)
    if different := [key for key, value in wanted.items() if meta.get(key) != value]:
        raise ForeignFile(f"{file}: contains migrants from another {', '.join(different)}")
    groups: dict[str, dict[str, np.ndarray]] = {}
    for key, array in arrays.items():
        species, _, name = key.partition("/")
        if species not in wander or array.ndim < 1 or array.dtype != OWN.get(name, array.dtype):
            raise CheckpointError(f"{file}: {key}: is not a migrants file")
        groups.setdefault(species, {})[name.removeprefix("columns/")] = array
    out = {}
    for species, group in groups.items():
        if not OWN.keys() <= group.keys() or len(set(map(len, group.values()))) > 1:
            raise CheckpointError(f"{file}: {species}: columns are missing or differ in length")
        uid, born, to = (group.pop(name) for name in OWN)
        out[species] = Migrants(uid, born, to, group)
    return out


KEEP = 3  # number of checkpoints kept per island
PATIENCE = 60.0  # [s] to wait for a worker that is ending to release an island's folder

Progress = Callable[[int, int], None]  # receives the ticks done and planned


class Live(NamedTuple):
    """An island that this process has run up to its current tick."""

    world: World
    folder: Any
    manifest: dict[str, Any]
    thread: int


_live: dict[Path, Live] = {}  # by folder


def advance(
    archipelago: str,
    name: str,
    start: int,
    until: int,
    threads: int = 1,
    trust: bool = False,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Run one island from tick `start` to `until`, and return its final state. At a barrier, migrants leave and
    arrive first; those that leave at `until` are written. Later files are overwritten with the same content."""
    root = Path(archipelago)
    plan, path = read(root), container.inside(root, root / ISLANDS / name)
    container.may_continue(root, plan, Manifest)

    def claimed() -> Claim:
        return Claim(path) if (path / "manifest.json").is_file() else claim_new(path)

    with finishing(), once_free(claimed, PATIENCE, 0.1) as claim:
        begin_ = time.perf_counter()
        live = _taken(path, start, claim) or _opened(claim, plan, name, start, threads, trust)
        world, folder, manifest = live.world, live.folder, live.manifest
        folder.claim = claim
        _forget_others(path, start)
        islands = world.config.archipelago
        if islands.meets(start):
            leave(world)
            admit(world, arrivals(root, plan["hash"], world, start))
        manifest |= {"ticks": until, "finished": False, "done": start, **folder.written}
        keep_manifest(folder, manifest)
        folder.forget_later()
        go_on(world, folder, manifest, until, progress, False, begin_)
        sent = write_migrants(path, plan["hash"], world) if islands.meets(until) else {}
        folder.claim = None
        _live[path] = live._replace(thread=threading.get_ident())
        return {
            "tick": until,
            "digest": manifest["digest"],
            "sent": sent,
            "n": {t.name: t.n for t in world.tables.values() if not t.species.is_object},
            "seconds": time.perf_counter() - begin_,
        }


def forget(archipelago: str | Path) -> None:
    """Drop the islands of an archipelago from this process's memory."""
    for path in [path for path in _live if path.parent.parent == Path(archipelago)]:
        del _live[path]


def report(archipelago: str, name: str) -> str:
    """Write the report of one island and return its path."""
    return str(write_report(Path(archipelago) / ISLANDS / name))


def _taken(path: Path, start: int, claim: Claim) -> Live | None:
    """Return the island if this process and thread has run it up to this tick, otherwise None."""
    live = _live.pop(path, None)
    if (
        live is None
        or live.world.tick != start
        or live.thread != threading.get_ident()
        or live.world.underway is not None
        or not (path / "manifest.json").is_file()
    ):
        return None
    return live if read_manifest(path).get("id") == live.manifest["id"] else None


def _opened(claim: Claim, plan: Mapping[str, Any], name: str, start: int, threads: int, trust: bool) -> Live:
    """Return an island at a tick, from its checkpoint or, at tick 0, newly built."""
    path = claim.path
    if not (path / "manifest.json").is_file():
        if start:
            raise CheckpointError(f"{path}: has no manifest.json, but the archipelago is at tick {start}")
        return _begun(claim, plan, name, threads, trust)
    manifest = read_manifest(path)
    check_island(path, manifest, plan["hash"], name)
    file = path / "checkpoints" / checkpoint.name_of(start)
    if not file.is_file():
        raise CheckpointError(
            f"{file}: no such file; without it the archipelago cannot continue from tick {start}"
        )
    world, folder = restored(file, claim, manifest, threads, trust)
    if start and world.digest() != plan["islands"].get(name, {}).get("digest"):
        raise ForeignFile(
            f"{file}: has a different digest than {FILE} records for the island {name} at tick {start}"
        )
    return Live(world, folder, manifest, threading.get_ident())


def _begun(claim: Claim, plan: Mapping[str, Any], name: str, threads: int, trust: bool) -> Live:
    """Build an island and begin its run with a checkpoint at tick 0."""
    config = config_of(claim.path.parent.parent, plan, trust, name)
    policies, learn = plan["policies"], plan["learn"]
    world = built(config, None, policies, threads, learn, ())
    manifest = manifest_of(world, plan["ticks"], policies, learn, ()) | {
        "island": name,
        "archipelago": plan["hash"],
        "snapshot_every": plan["snapshot_every"] or snapshots(config, plan["ticks"]),
        "checkpoint_every": None,
        "keep": 10**9,
        "record": plan["record"],
    }
    with begun(claim):
        folder = begin(world, claim, manifest, weights_files(config, policies), None)
    return Live(world, folder, manifest, threading.get_ident())


def config_of(root: Path, plan: Mapping[str, Any], trust: bool, name: str) -> WorldConfig:
    """Return the configuration of one island of an archipelago, with the seed of its run."""
    config = recorded(root, dict(plan), dict(plan["config"]) | {"seed": plan["seed"]}, trust)
    config._folder = Path(plan["folder"])
    return island_of(config, name)


def _forget_others(path: Path, start: int) -> None:
    """Remove an island's checkpoints after a tick, because they will be rewritten, and its older ones."""
    files = sorted((path / "checkpoints").glob(f"tick-*{checkpoint.SUFFIX}"))
    before = [file for file in files if checkpoint.tick_of(file) <= start]
    for file in [file for file in files if file not in before] + before[:-KEEP]:
        file.unlink(missing_ok=True)
