"""One island from one barrier to the next: a piece of work that may be done again, anywhere, with the same
result."""

import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ecs_eco.archipelago import exports
from ecs_eco.config import WorldConfig
from ecs_eco.config.loading import island_of
from ecs_eco.engine.errors import CheckpointError, FolderInUse, ForeignFile
from ecs_eco.experiments.workers import finishing
from ecs_eco.life.migration import admit, leave
from ecs_eco.record import checkpoint, container
from ecs_eco.record.archipelago import FILE, ISLANDS, Manifest, check_island, read
from ecs_eco.record.claim import Claim, claim_new
from ecs_eco.record.container import inside
from ecs_eco.runs.begin import begin, begun, keep_manifest
from ecs_eco.runs.run import built, go_on, manifest_of, read_manifest, restored, snapshots

KEEP = 3  # checkpoints at barriers, of each island
PATIENCE = 60.0  # [s] for a worker that is just ending to give back the folder of an island

Progress = Callable[[int, int], None]


class Live(NamedTuple):
    """An island that this process has run up to where it is."""

    world: Any
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
    """Run one island of the archipelago in a folder from tick `start` to `until`; return its state there.

    At a barrier migrants leave and arrive first, as the files `exports` of its neighbours say; those that
    leave at `until` are written to its own. Whatever was there of later ticks is written anew, the same.
    """
    root = Path(archipelago)
    plan, path = read(root), inside(root, root / ISLANDS / name)
    container.may_continue(root, plan, Manifest)
    with finishing(), _claimed(path) as claim:
        begin_ = time.perf_counter()
        live = _taken(path, start, claim) or _opened(claim, plan, name, start, threads, trust)
        world, folder, manifest = live.world, live.folder, live.manifest
        folder.claim = claim
        _forget_others(path, start)
        islands = world.config.archipelago
        if islands.meets(start):
            leave(world)
            admit(world, exports.of_neighbours(root, plan["hash"], world, start))
        manifest |= {"ticks": until, "finished": False, "done": start, **folder.written}
        keep_manifest(folder, manifest)
        folder.forget_later()
        go_on(world, folder, manifest, until, progress, False, begin_)
        sent = exports.write(path, plan["hash"], world) if islands.meets(until) else {}
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
    """Let go of the islands of an archipelago that this process keeps in memory."""
    for path in [path for path in _live if path.parent.parent == Path(archipelago)]:
        del _live[path]


def report(archipelago: str, name: str) -> str:
    """Write the report of one island; return its path."""
    from ecs_eco.analysis.report import write_report

    return str(write_report(Path(archipelago) / ISLANDS / name))


def _claimed(path: Path) -> Claim:
    """Claim the folder of an island, new or not; a worker that was told to end may have it a moment longer."""
    until = time.monotonic() + PATIENCE
    while True:
        try:
            return Claim(path) if (path / "manifest.json").is_file() else claim_new(path)
        except FolderInUse:
            if time.monotonic() > until:
                raise
            time.sleep(0.1)


def _taken(path: Path, start: int, claim: Claim) -> Live | None:
    """Return the island that this process and thread has run up to this tick, if it has."""
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
    """Return an island as it was at a tick: from its checkpoint, or from the beginning."""
    path = claim.path
    if not (path / "manifest.json").is_file():
        if start:
            raise CheckpointError(f"{path}: has no manifest.json, and the archipelago is at tick {start}")
        return _begun(claim, plan, name, threads, trust)
    manifest = read_manifest(path)
    check_island(path, manifest, plan["hash"], name)
    file = path / "checkpoints" / checkpoint.name_of(start)
    if not file.is_file():
        raise CheckpointError(
            f"{file}: no such file; without it the archipelago cannot go on from tick {start}"
        )
    world, folder = restored(file, claim, manifest, threads, trust)
    if start and world.digest() != plan["islands"].get(name, {}).get("digest"):
        raise ForeignFile(f"{file}: has another digest than {FILE} says of the island {name} at tick {start}")
    return Live(world, folder, manifest, threading.get_ident())


def _begun(claim: Claim, plan: Mapping[str, Any], name: str, threads: int, trust: bool) -> Live:
    """Build an island and begin its run, with a checkpoint at tick 0."""
    from ecs_eco.worlds.policies import weights_files

    config = config_of(claim.path.parent.parent, plan, trust, name)
    policies, learn = plan["policies"], plan["learn"]
    world = built(config, None, policies, threads, learn, ())
    every = plan["snapshot_every"] or snapshots(config, plan["ticks"])
    manifest = manifest_of(world, plan["ticks"], policies, learn, ()) | {
        "island": name,
        "archipelago": plan["hash"],
        "snapshot_every": every,
        "checkpoint_every": None,
        "keep": 10**9,
        "record": plan["record"],
    }
    with begun(claim):
        folder = begin(world, claim, manifest, weights_files(config, policies), None)
    return Live(world, folder, manifest, threading.get_ident())


def config_of(root: Path, plan: Mapping[str, Any], trust: bool, name: str) -> WorldConfig:
    """Return the world file of one island of an archipelago, with the seed of its run."""
    from ecs_eco.record.code import recorded

    config = recorded(root, dict(plan), dict(plan["config"]) | {"seed": plan["seed"]}, trust)
    config._folder = Path(plan["folder"])
    return island_of(config, name)


def _forget_others(path: Path, start: int) -> None:
    """Remove checkpoints of an island after a tick, which will be written again, and old ones before it."""
    files = sorted((path / "checkpoints").glob(f"tick-*{checkpoint.SUFFIX}"))
    before = [file for file in files if checkpoint.tick_of(file) <= start]
    for file in [file for file in files if file not in before] + before[:-KEEP]:
        file.unlink(missing_ok=True)
