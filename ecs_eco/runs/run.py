"""A run that leaves a folder, can be stopped at any moment, and goes on from its last checkpoint to the same bytes."""

import math
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from ecs_eco.checkpoint import file as checkpoint
from ecs_eco.checkpoint import freeze as frozen
from ecs_eco.engine.errors import CheckpointError, RecordingError
from ecs_eco.record import seal
from ecs_eco.record.details import how_many
from ecs_eco.record.folder import Folder, genes_of, git_commit, versions
from ecs_eco.runs.requests import Asked, ask_again, forget

Progress = Callable[[int, int], None]
KEEP = 3  # checkpoints


class Stopped(KeyboardInterrupt):
    """A run that was told to stop, after the end of its tick and with a checkpoint."""

    def __init__(self, tick: int, folder: Path) -> None:
        super().__init__(f"stopped at tick {tick}; go on with: ecs-eco resume {folder}")
        self.tick, self.folder = tick, folder


def run_to_folder(config: Any, seed: int | None = None, ticks: int | None = None, out: str | Path = "run", policies: Any = "trained",
                  learn: bool | None = None, progress: Progress | None = None, *, threads: int = 1, snapshot_every: int | None = None,
                  report: bool = True, command: str | None = None, controls: Sequence[str] = (), checkpoint_every: int | None = None,
                  keep: int = KEEP, record: str | None = None, prepare: Callable[[Any], None] | None = None) -> dict[str, Any]:
    """Run a world, with these controls of `ecs_eco.worlds.treatments`, and leave a folder; return its manifest.

    `record` asks for details of single organisms: "focal=N" of each species, or "full" (see `ecs_eco.record.details`).

    A checkpoint is written at tick 0, every `checkpoint_every` ticks if asked for, and at the end; the last `keep` stay. Ctrl-C and
    SIGTERM stop at the end of the tick with a checkpoint and raise Stopped; a second one stops at once. `prepare(world)` is called
    before the first tick: a viewer begins there. Raises FileExistsError where `out` holds something; RecordingError where nothing
    can be written any more.
    """
    from ecs_eco.config import WorldConfig, load

    begin = time.perf_counter()
    config = config if isinstance(config, WorldConfig) else load(config)
    how_many(record, "record")
    ticks = config.ticks if ticks is None else ticks
    path = Path(out)
    _free(path)
    world = _build(config, seed, policies, threads, learn, controls)
    every = snapshots(config, ticks) if snapshot_every is None else snapshot_every
    manifest = {
        "format": 1, "world": config.name, "title": config.title, "config": config.resolved(), "config_hash": config.config_hash,
        "seed": world.seed, "ticks": ticks, "dt": config.dt, "policies": str(policies), "learn": learn, "controls": list(controls),
        "command": command, "versions": versions(), "git_commit": git_commit(), "snapshot_every": every,
        "checkpoint_every": checkpoint_every, "keep": keep, "record": record,
        "wall_seconds": 0.0,
    }  # fmt: skip
    folder = _record(world, path, manifest)
    if prepare is not None:
        prepare(world)
    _checkpoint(world, folder, manifest)  # whatever happens later, there is one to go on from
    return _go(world, folder, manifest, ticks, progress, report, begin)


def resume(path: str | Path, until: int | None = None, progress: Progress | None = None, *, threads: int = 1, report: bool = True,
           complain: Callable[[str], None] = print, prepare: Callable[[Any], None] | None = None) -> dict[str, Any]:
    """Go on with the run in a folder, from its last whole checkpoint to tick `until`; return its manifest.

    `prepare(world)` is called before the first tick that follows: a viewer opens.

    What was recorded after that checkpoint is recorded again, the same. Raises RecordingError for a folder without a run,
    or one that is there already; CheckpointError.
    """
    begin, path = time.perf_counter(), Path(path)
    manifest = read_manifest(path)
    until = manifest["ticks"] if until is None else until
    found = checkpoint.latest(path / "checkpoints", complain=complain)
    if found is None and "forked" in manifest:
        raise CheckpointError(f"{path}: is a fork of {manifest['forked']['from']} without a checkpoint; fork that one again")
    if found is None:
        world, folder = _from_the_start(path, manifest, threads)
    else:
        world, folder = _from(found, path, manifest, threads)
    if until < world.tick:
        raise RecordingError(f"{path}: is at tick {world.tick} already; --until {until} lies before that. A fork goes on from an "
                             f"earlier one: --from-tick {until} --out NEW")  # fmt: skip
    folder.forget_later()
    manifest |= {"ticks": until, "finished": False}
    if prepare is not None:
        prepare(world)
    return _go(world, folder, manifest, until, progress, report, begin)


def fork(path: str | Path, out: str | Path, from_tick: int | None = None, changes: Any = (), until: int | None = None,
         progress: Progress | None = None, *, threads: int = 1, report: bool = True, command: str | None = None,
         complain: Callable[[str], None] = print, prepare: Callable[[Any], None] | None = None) -> dict[str, Any]:
    """Go on from a tick of a recorded run in a folder of its own, with changed values; return its manifest.

    `prepare(world)` is called before the first tick of the fork: a viewer opens.

    The world is restored from the last checkpoint at or before `from_tick` (the last of all where it is None) and runs exactly as
    it did up to that tick; then `changes` ("key=value", or a dict) take effect. What was asked for by hand in that tick or later is not
    carried out. The recording begins there.
    """
    from ecs_eco.ecosystem import World

    begin, path, out = time.perf_counter(), Path(path), Path(out)
    manifest = read_manifest(path)
    _free(out)
    found = checkpoint.latest(path / "checkpoints", before=from_tick, complain=complain)
    if found is None:
        raise CheckpointError(f"{path}: has no checkpoint at or before tick {from_tick}; run it with --checkpoint-every N")
    world = World.restore(found, threads=threads, record=False)
    if from_tick is not None and from_tick > world.tick:
        world.between = partial(ask_again, world, manifest)
        world.run(from_tick - world.tick)
        world.between = None
    forget(world)
    if changes:
        from ecs_eco.config.loading import changed
        from ecs_eco.worlds.reconfigure import reconfigure

        reconfigure(world, changed(world.config, changes))
    until = max(manifest["ticks"], world.tick) if until is None else until
    if until < world.tick:
        raise RecordingError(f"{path}: the fork begins at tick {world.tick}; --until {until} lies before that")
    told = dict(changes) if isinstance(changes, dict) else list(changes)
    manifest |= {
        "config": world.config.resolved(), "config_hash": world.config.config_hash, "ticks": until, "command": command, "wall_seconds": 0.0,
        "versions": versions(), "git_commit": git_commit(), "forked": {"from": str(path), "tick": world.tick, "changes": told},
        "asked": [],
    }  # fmt: skip
    folder = _record(world, out, manifest)
    if prepare is not None:
        prepare(world)
    _checkpoint(world, folder, manifest)
    return _go(world, folder, manifest, until, progress, report, begin)


def read_manifest(path: Path) -> dict[str, Any]:
    """Return the manifest of a run folder; raises RecordingError that says what is wrong with it."""
    try:
        manifest = {key: value for key, value in seal.read_manifest(path).items() if key != seal.WORD}
    except FileNotFoundError as error:
        raise RecordingError(str(error)) from None
    if manifest.get("format") != 1 or not {"config", "seed", "ticks"} <= set(manifest):
        raise RecordingError(f"{path / 'manifest.json'}: is no manifest of a run, or of another version of ecs-eco")
    return manifest


def _build(config: Any, seed: Any, policies: Any, threads: int, learn: Any, controls: Sequence[str]) -> Any:
    from ecs_eco.ecosystem import World

    return World.from_config(config, seed=seed, policies=policies, threads=threads, learn=learn, controls=controls, record=False)


def snapshots(config: Any, ticks: int) -> int:
    """Return the ticks between snapshots, about 100 in a run; under a sun they fall on all hours of the day."""
    every, sun = max(1, ticks // 100), config.sun
    day = round(sun.day / config.dt) if sun is not None else 0
    while day > 1 and math.gcd(every, day) > 1:
        every += 1
    return every


def _free(path: Path) -> None:
    if path.exists() and (not path.is_dir() or any(path.iterdir())):
        raise FileExistsError(f"{path} exists and is not an empty folder; name another with --out")


def _record(world: Any, path: Path, manifest: dict[str, Any]) -> Folder:
    """Begin a recording in a new folder, and write its manifest."""
    from ecs_eco.record.recorder import Recorder

    folder = Folder(path, world)
    Recorder(world, folder.sink, snapshot_every=manifest["snapshot_every"], record=manifest.get("record"))
    manifest |= {
        "species": world.recorder.names, "causes": world.causes, "finished": False, "done": world.tick, "parts": {},
        "colors": {name: world.tables[name].traits.get("color", "#888888") for name in world.recorder.names},
        "genomes": {name: said for name in world.recorder.names if (said := genes_of(world.tables[name]))},
    }  # fmt: skip
    path.mkdir(parents=True, exist_ok=True)
    seal.write_manifest(path, manifest)
    return folder


def _from(found: Path, path: Path, manifest: dict[str, Any], threads: int) -> tuple[Any, Folder]:
    """Restore a checkpoint of a run, and its recorder as it was then."""
    from ecs_eco.ecosystem import World
    from ecs_eco.record.recorder import Recorder

    folders: list[Folder] = []

    def record(world: Any) -> None:
        folders.append(Folder(path, world))
        Recorder(world, folders[0].sink, snapshot_every=manifest["snapshot_every"], record=manifest.get("record"))

    world = World.restore(found, threads=threads, prepare=record, record=False)
    parts = checkpoint.describe(found)["run"]["parts"]
    folders[0].parts = {kind: int(n) for kind, n in parts.items()}
    return world, folders[0]


def _from_the_start(path: Path, manifest: dict[str, Any], threads: int) -> tuple[Any, Folder]:
    """Begin a run anew that was stopped before its first checkpoint."""
    from ecs_eco.config import load
    from ecs_eco.record.recorder import Recorder

    config = load(manifest["config"])
    world = _build(config, manifest["seed"], manifest["policies"], threads, manifest["learn"], manifest.get("controls", ()))
    folder = Folder(path, world)
    Recorder(world, folder.sink, snapshot_every=manifest["snapshot_every"], record=manifest.get("record"))
    return world, folder


def _checkpoint(world: Any, folder: Folder, manifest: dict[str, Any]) -> None:
    """Write a checkpoint of a run; then forget those before the last `keep`."""
    meta, arrays = frozen.freeze(world)
    place = folder.path / "checkpoints"
    checkpoint.write(place / checkpoint.name_of(world.tick), meta | {"run": {"parts": dict(folder.parts)}}, arrays)
    for old in sorted(place.glob(f"tick-*{checkpoint.SUFFIX}"))[: -max(1, manifest["keep"])]:
        old.unlink(missing_ok=True)


def _go(world: Any, folder: Folder, manifest: dict[str, Any], until: int, progress: Progress | None, report: bool,
        begin: float) -> dict[str, Any]:
    """Let a recorded world run to a tick, with checkpoints; leave everything whole whatever happens."""
    every, path = manifest.get("checkpoint_every") or 0, folder.path
    first, spent, whole = world.tick, float(manifest.get("wall_seconds", 0.0)), False
    asked = Asked(world, manifest, lambda: seal.write_manifest(path, manifest))
    start = time.perf_counter()
    try:
        with _stopping(world):
            while world.tick < until and not world.stopping:
                goal = min(until, (world.tick // every + 1) * every if every else until, first + 1 if world.tick == first else until)
                at = world.tick
                world.run(goal - at, None if progress is None else lambda done, _, at=at: progress(at + done, until))
                if at == first:
                    manifest["startup_seconds"], start = time.perf_counter() - begin, time.perf_counter()
                if every and world.tick % every == 0 and world.tick < until:
                    _checkpoint(world, folder, manifest)
                    manifest |= _state(world) | {"parts": dict(folder.parts)}
                    seal.write_manifest(path, manifest)
        whole = True
    except OSError as error:
        raise RecordingError(_cannot_write(error, world, path)) from error
    finally:
        world.between = asked.before
        manifest["wall_seconds"] = spent + time.perf_counter() - start
        _close(world, folder, manifest, finished=whole and world.tick >= until, last=whole)
    if not manifest["finished"]:
        raise Stopped(world.tick, path)
    if report:
        from ecs_eco.analysis.report import write_report

        write_report(path)
    return manifest


def _close(world: Any, folder: Folder, manifest: dict[str, Any], finished: bool, last: bool) -> None:
    """Write what is left, a last checkpoint where the tick is whole, and the manifest; says so where that is not possible."""
    try:
        world.recorder.flush()
        if last:
            _checkpoint(world, folder, manifest)
        manifest |= _state(world) | {"finished": finished, "digest": world.digest(), "parts": dict(folder.parts)}
        seal.write_manifest(folder.path, manifest)
    except OSError as error:
        raise RecordingError(_cannot_write(error, world, folder.path)) from error


def _state(world: Any) -> dict[str, Any]:
    return {"done": world.tick, "causes": world.causes, "intervened": [list(done) for done in world.intervened]}


def _cannot_write(error: OSError, world: Any, path: Path) -> str:
    kept = sorted((path / "checkpoints").glob(f"tick-*{checkpoint.SUFFIX}"))
    last = f"; the last checkpoint is of tick {checkpoint.tick_of(kept[-1])}: make room, then ecs-eco resume {path}" if kept else ""
    why = error.strerror or error
    return f"{path}: nothing more can be written at tick {world.tick}: {why}; what was recorded until then is whole{last}"


@contextmanager
def _stopping(world: Any) -> Iterator[None]:
    """Let SIGINT and SIGTERM stop the world at the end of its tick; the second one stops at once."""
    world.stopping = False
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(number: int, frame: Any) -> None:
        if world.stopping:
            raise KeyboardInterrupt
        world.stopping = True

    before = {}
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            before[number] = signal.signal(number, stop)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def leftovers(path: Path) -> list[Path]:
    """Return what half-written files a killed run left in its folder."""
    return [p for p in path.rglob("*.tmp") if p.is_file()] if path.is_dir() else []

