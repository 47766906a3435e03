"""A recorded run, which can be stopped at any moment and resumed bit for bit from its last checkpoint."""

import math
import re
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ecs_eco.compiled import portable
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.checks.reporters import problems_of_rules, rule_of
from ecs_eco.config.loading import WorldSource, changed
from ecs_eco.config.overrides import Overrides
from ecs_eco.ecosystem import World
from ecs_eco.engine import files
from ecs_eco.engine.arguments import called_with, optional_number, whole_number
from ecs_eco.engine.errors import CheckpointError, ConfigError, Halted, RecordingError
from ecs_eco.engine.hooks import listening
from ecs_eco.engine.versions import versions
from ecs_eco.life.reconfigure import reconfigure
from ecs_eco.record import belonging, checkpoint, container, seal
from ecs_eco.record.claim import DATA, Claim, stopped_early
from ecs_eco.record.details import how_many
from ecs_eco.record.folder import Folder, check_content, git_commit
from ecs_eco.record.reports import past_values, value_of
from ecs_eco.runs.begin import (
    begin,
    begun,
    keep_checkpoint,
    keep_manifest,
    policies_as_json,
    recording,
    start_of,
)
from ecs_eco.runs.requests import forget, note_requests, repeat_requests
from ecs_eco.runs.signals import stopping
from ecs_eco.worlds.policies import Learn, Policies, weights_files

Progress = Callable[[int, int], None]
KEEP = 3  # checkpoints


class Stopped(KeyboardInterrupt):
    """Raised when a run stops on request, after it has completed its tick and written a checkpoint."""

    def __init__(self, tick: int, folder: Path) -> None:
        super().__init__(f"stopped at tick {tick}; resume with: ecs-eco resume {folder}")
        self.tick, self.folder = tick, folder


def run_to_folder(
    config: WorldSource,
    seed: int | None = None,
    ticks: int | None = None,
    out: str | Path | Claim = "run",
    policies: Policies = "trained",
    learn: bool | None = None,
    progress: Progress | None = None,
    *,
    threads: int = 1,
    snapshot_every: int | None = None,
    report: bool = True,
    command: str | None = None,
    controls: Sequence[str] = (),
    checkpoint_every: int | None = None,
    keep: int = KEEP,
    record: str | None = None,
    until: Sequence[str] = (),
    prepare: Callable[[Any], None] | None = None,
    trust: bool = False,
) -> dict[str, Any]:
    """Run a world, record it in a new folder, and return the run's manifest.

    Parameters
    ----------
    config : str, Path, Mapping or WorldConfig
        The world, as in `World.from_config`.
    seed : int, optional
        Fixes every random draw; default: the world file's `seed`.
    ticks : int, optional
        Length of the run [ticks]; default: the world file's `ticks`.
    out : str or Path, default "run"
        Results folder, which must be new or empty.
    policies : str, Path or Mapping, default "trained"
        As in `World.from_config`.
    learn : bool, optional
        Whether species learn; default: as in the world file.
    progress : callable, optional
        Called as `progress(done, ticks)` about ten times a second.
    threads : int, default 1
        Number of threads; affects speed, never results.
    snapshot_every : int, optional
        Ticks between snapshots of all organisms; default: a hundredth of the run.
    report : bool, default True
        Whether to write report.html at the end.
    command : str, optional
        Command line to store in the manifest.
    controls : sequence of str
        Treatments that remove something, as in `World.from_config`.
    checkpoint_every : int, optional
        Ticks between checkpoints; default: checkpoints only at tick 0 and at the end.
    keep : int, default 3
        Number of checkpoints to keep.
    record : str, optional
        Organisms to record in every tick: "focal=N" for N organisms of each species, or "full" for all of them.
    until : sequence of str, optional
        Conditions over numbers of organisms and reporters, such as "wolf == 0"; the run ends after the first
        tick in which one is true, and the manifest names it in `ended`.
    prepare : callable, optional
        Called with the world before the first tick.
    trust : bool, default False
        Whether the code listed in the file's `code` is allowed to run in this process. The folder stores a
        copy of the code.

    Returns
    -------
    dict
        The manifest, which is also written to manifest.json.

    Raises
    ------
    Stopped
        A KeyboardInterrupt, raised after Ctrl-C or SIGTERM, once the tick is complete and a checkpoint is
        written.
    FileExistsError
        If `out` is not empty.
    FolderInUse
        If another process is writing there.
    RecordingError
        If writing fails.

    Examples
    --------
    >>> from ecs_eco.runs.run import run_to_folder
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=5, out="my-run", report=False)
    >>> manifest["done"]
    5
    """

    start = time.perf_counter()
    called_with("progress", progress, "done", "ticks")
    config = config if isinstance(config, WorldConfig) and not trust else load(config, trust=trust)
    how_many(record, "record")
    ticks = config.ticks if ticks is None else whole_number("ticks", ticks)
    every = optional_number("snapshot_every", snapshot_every, 1) or snapshots(config, ticks)
    checkpoint_every = optional_number("checkpoint_every", checkpoint_every, 1)
    keep = whole_number("keep", keep, 1)
    if wrong := [p.moved(key=(), source="--until") for p in problems_of_rules(config, until)]:
        raise ConfigError(wrong)
    with begun(out) as claim:
        world = World.from_config(
            config,
            seed=seed,
            policies=policies,
            threads=threads,
            learn=learn,
            controls=controls,
            record=False,
        )
        manifest = manifest_of(world, ticks, policies, learn, controls) | {
            "command": command,
            "snapshot_every": every,
            "checkpoint_every": checkpoint_every,
            "keep": keep,
            "record": record,
            "until": list(until),
        }
        folder = begin(world, claim, manifest, weights_files(config, policies), prepare)
        return go_on(world, folder, manifest, ticks, progress, report, start)


def resume(
    path: str | Path,
    until: int | None = None,
    progress: Progress | None = None,
    *,
    threads: int = 1,
    report: bool = True,
    complain: Callable[[str], None] = print,
    prepare: Callable[[Any], None] | None = None,
    trust: bool = False,
) -> dict[str, Any]:
    """Resume the run in a folder from its last intact checkpoint, and return its manifest.

    An unfinished run is recorded again from that checkpoint, with the same result.

    Parameters
    ----------
    path : str or Path
        Folder of the run.
    until : int, optional
        Last tick; default: the planned end of the run.
    progress : callable, optional
        Called as `progress(done, ticks)` about ten times a second.
    threads : int, default 1
        Number of threads; affects speed, never results.
    report : bool, default True
        Whether to write report.html at the end.
    complain : callable, default print
        Called with a message for each damaged checkpoint.
    prepare : callable, optional
        Called with the world before its next tick.
    trust : bool, default False
        Whether the code in the folder is allowed to run in this process.

    Returns
    -------
    dict
        The manifest.

    Raises
    ------
    RecordingError
        If the folder contains no run, or its run is past `until` or was recorded in the other numerical mode.
    FolderInUse
        If another process is writing there.
    ForeignFile
        If a checkpoint or a part belongs to another run, or a link leads out of the folder.
    CheckpointError
        If records would be lost: no checkpoint is intact or, for a finished run, not the last one.

    Examples
    --------
    >>> from ecs_eco.runs.run import resume, run_to_folder
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=3, out="my-run", report=False)
    >>> resume("my-run", until=5, report=False)["done"]
    5
    """
    start, path = time.perf_counter(), Path(path)
    called_with("progress", progress, "done", "ticks")
    read_manifest(path)
    with Claim(path) as claim:
        manifest = _with_id(path, read_manifest(path))
        if "island" in manifest:
            raise RecordingError(
                f"{path}: is the island {manifest['island']} of an archipelago, which can only be "
                f"resumed as a whole: ecs-eco resume {path.parent.parent}"
            )
        container.may_continue(path / "manifest.json", manifest)
        planned = manifest["ticks"]
        until = planned if until is None else whole_number("until", until)
        newest = checkpoint.latest(
            path / "checkpoints", complain=complain, check=partial(belonging.check_checkpoint, manifest)
        )
        if newest is None and "forked" in manifest:
            raise CheckpointError(
                f"{path}: is a fork of {manifest['forked']['from']} without a checkpoint; fork that run again"
            )
        reached = 0 if newest is None else checkpoint.tick_of(newest)
        if reached < manifest["done"] and (newest is None or manifest["finished"]):
            raise CheckpointError(
                f"{path}: has records up to tick {manifest['done']}, but "
                f"{f'its last intact checkpoint is from tick {reached}' if newest else 'no intact checkpoint'}, "
                f"so resuming would delete records. Fork it instead: ecs-eco resume {path} --from-tick "
                f"{manifest['done']} --out NEW --until LATER"
            )
        if newest is None:
            world = World.from_config(threads=threads, record=False, **start_of(path, manifest, trust=trust))
            folder = recording(claim, world, manifest)
            folder.go_on_from({"parts": folder.parts, "heads": {}}, manifest)
        else:
            world, folder = restored(newest, claim, manifest, threads, trust)
        if until < world.tick:
            raise RecordingError(
                f"{path}: is already at tick {world.tick}, later than --until {until}. Fork it from "
                f"an earlier tick: --from-tick {until} --out NEW"
            )
        check_content(path, folder.parts)
        manifest |= {"ticks": until, "finished": False, "ended": None, **folder.written}
        if manifest["command"] is not None:
            manifest["command"] = re.sub(
                rf"(--ticks|--until) {planned}\b", rf"\1 {until}", manifest["command"]
            )
        keep_manifest(folder, manifest)  # must precede the deletion of parts beyond this count
        folder.forget_later()
        if prepare is not None:
            prepare(world)
        return go_on(world, folder, manifest, until, progress, report, start)


def fork(
    path: str | Path,
    out: str | Path | Claim,
    from_tick: int | None = None,
    changes: Overrides = (),
    until: int | None = None,
    progress: Progress | None = None,
    *,
    threads: int = 1,
    report: bool = True,
    command: str | None = None,
    complain: Callable[[str], None] = print,
    prepare: Callable[[Any], None] | None = None,
    trust: bool = False,
) -> dict[str, Any]:
    """Continue a recorded run from one of its ticks in a new folder, with changed values.

    The world runs exactly as it did up to that tick; then the changes take effect. Interventions requested by
    hand in that tick or later are not carried out.

    Parameters
    ----------
    path : str or Path
        Folder of the run, which is not changed.
    out : str or Path
        New folder.
    from_tick : int, optional
        Tick at which to fork; default: the last checkpoint.
    changes : Mapping or sequence of str
        Dotted keys with values, or strings such as "species.deer.metabolism.basal=0.005".
    until : int, optional
        Last tick; default: the planned end of the run.
    progress, threads, report, complain, prepare, trust
        As in `resume`.
    command : str, optional
        Command line to store in the manifest.

    Returns
    -------
    dict
        The manifest of the fork.

    Examples
    --------
    >>> from ecs_eco.runs.run import fork, run_to_folder
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=3, out="my-run", report=False)
    >>> changes = {"species.deer.metabolism.basal": 0.008}
    >>> hungry = fork("my-run", "hungry", changes=changes, until=5, report=False)
    >>> hungry["forked"]["tick"], hungry["done"]
    (3, 5)
    """
    start, path = time.perf_counter(), Path(path)
    called_with("progress", progress, "done", "ticks")
    manifest = _with_id(path, read_manifest(path))
    until = manifest["ticks"] if until is None else whole_number("until", until)

    def require_later(tick: int) -> None:
        if until <= tick:
            fault = f"the fork begins at tick {tick}, but ends at tick {until}"
            raise RecordingError(f"{path}: {fault}; expected: --until above {tick}")

    require_later(optional_number("from_tick", from_tick) or 0)
    with begun(out) as claim:
        if (data := path / DATA).is_file():
            files.write(claim.path / DATA, files.read_bytes(data))
        world = world_at(path, manifest, from_tick, threads, complain, trust)
        require_later(world.tick)
        forget(world)
        if changes:
            reconfigure(world, changed(world.config, changes))
        listed = dict(changes) if isinstance(changes, dict) else list(changes or ())
        manifest |= {
            "config": world.config.resolved(),
            "config_hash": world.config.config_hash,
            "ticks": until,
            "command": command,
            "wall_seconds": 0.0,
            "versions": versions(),
            "target": portable.target(),
            "git_commit": git_commit(),
            "asked": [],
            "until": [],
            "ended": None,
            "parts": {},
            "heads": {},
            "forked": {
                "from": str(path),
                "id": manifest["id"],
                "tick": world.tick,
                "changes": listed,
                "digest": world.digest(),
            },
        }
        folder = begin(world, claim, manifest, {}, prepare)
        return go_on(world, folder, manifest, until, progress, report, start)


def world_at(
    path: Path,
    manifest: dict[str, Any],
    tick: int | None,
    threads: int,
    complain: Callable[[str], None],
    trust: bool,
) -> Any:
    """Return the world of a recorded run at a tick (None: the last checkpoint), without recording."""
    world = near(path, manifest, tick, trust, threads, complain)
    if tick is not None and tick > world.tick:
        with listening(world.before_tick, partial(repeat_requests, world, manifest)):
            world.run(tick - world.tick)
    return world


def near(
    path: Path,
    manifest: dict[str, Any],
    tick: int | None,
    trust: bool = False,
    threads: int = 1,
    complain: Callable[[str], None] | None = None,
) -> Any:
    """Return the world at the last checkpoint at or before a tick or, if there is none, at the start of the run;
    for no tick, for a fork and for an island, only at a checkpoint.

    To continue as the run did, call `repeat_requests` before each tick. Raises CheckpointError,
    RecordingError or ConfigError for a run that cannot be repeated here.
    """
    check = partial(belonging.check_checkpoint, manifest) if "id" in manifest else None  # old runs have no id
    file = checkpoint.latest(path / "checkpoints", before=tick, complain=complain, check=check)
    if file is not None:
        return World.restore(file, threads=threads, record=False, trust=trust)
    if tick is None or not manifest.keys().isdisjoint(("forked", "island")):
        at = "" if tick is None else f" at or before tick {tick}, and cannot be repeated from its start"
        raise CheckpointError(
            f"{path}: has no intact checkpoint{at}; keep more: ecs-eco run … --checkpoint-every N --keep K"
        )
    return World.from_config(threads=threads, record=False, **start_of(path, manifest, trust=trust))


def read_manifest(path: Path) -> dict[str, Any]:
    """Return the manifest of a run folder.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict
        World, seed, completed ticks, versions, digest and more.

    Raises
    ------
    RecordingError
        If there is no run, or its manifest is damaged.

    Examples
    --------
    >>> from pathlib import Path
    >>> from ecs_eco.runs.run import read_manifest, run_to_folder
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=2, out="my-run", report=False)
    >>> read_manifest(Path("my-run"))["seed"]
    1
    """
    try:
        manifest = {key: value for key, value in seal.read_manifest(path).items() if key != seal.WORD}
    except FileNotFoundError as error:
        early = f"; a run was killed there before it started: run it again with --out {path}"
        raise RecordingError(f"{error}{early if stopped_early(path) else ''}") from None
    known = manifest.get("format") in (1, belonging.FORMAT)
    if not known or not {"config", "seed", "ticks"} <= manifest.keys():
        raise RecordingError(
            f"{path / 'manifest.json'}: is not the manifest of a run, or is from another version of ecs-eco"
        )
    return manifest


def _with_id(path: Path, manifest: dict[str, Any]) -> dict[str, Any]:
    """Return a manifest that lists the files of its run; raise RecordingError for an older format."""
    if "id" not in manifest:
        raise RecordingError(
            f"{path / 'manifest.json'}: has format {manifest['format']} of an older version of "
            "ecs-eco: such a run can be read and repeated, but not resumed"
        )
    return manifest


def manifest_of(
    world: World, ticks: int, policies: Policies, learn: Learn, controls: Sequence[str]
) -> dict[str, Any]:
    """Return the manifest entries for a run of a world with this configuration."""
    config = world.config
    return {
        "format": belonging.FORMAT,
        "world": config.name,
        "title": config.title,
        "config": config.resolved(),
        "config_hash": config.config_hash,
        "seed": world.seed,
        "ticks": ticks,
        "dt": config.dt,
        "policies": policies_as_json(policies),
        "learn": learn,
        "controls": list(controls),
        "command": None,
        "versions": versions(),
        "target": portable.target(),
        "git_commit": git_commit(),
        "wall_seconds": 0.0,
    }


def snapshots(config: WorldConfig, ticks: int) -> int:
    """Return the number of ticks between snapshots, for about 100 snapshots per run and, with a sun, at all
    hours of the day."""
    every, sun = max(1, ticks // 100), config.sun
    day = round(sun.day / config.dt) if sun is not None else 0
    while day > 1 and math.gcd(every, day) > 1:
        every += 1
    return every


def restored(
    file: Path, claim: Claim, manifest: dict[str, Any], threads: int, trust: bool
) -> tuple[Any, Folder]:
    """Restore a checkpoint of a run and its recorder, after checking that earlier parts belong to it."""

    written = belonging.check_checkpoint(manifest, file, checkpoint.describe(file))
    del written["id"]
    folders: list[Folder] = []
    world = World.restore(
        file,
        threads=threads,
        prepare=lambda world: folders.append(recording(claim, world, manifest)),
        record=False,
        trust=trust,
    )
    folders[0].go_on_from(written, manifest)
    return world, folders[0]


def go_on(
    world: World,
    folder: Folder,
    manifest: dict[str, Any],
    until: int,
    progress: Progress | None,
    report: bool,
    begin: float,
) -> dict[str, Any]:
    """Run a recorded world up to a tick, with checkpoints; the folder is always left in a consistent state."""
    every, path = manifest.get("checkpoint_every") or 0, folder.path
    first, spent, whole = world.tick, float(manifest.get("wall_seconds", 0.0)), False

    rules = [rule_of(world.config, text) for text in manifest.get("until", ())]
    for rule in rules:
        if rule.window and first > 1:  # the value after the last tick follows in `look`
            rule.values += past_values(world, path / "series", rule.formula)[: first - 1]

    def look() -> None:
        now = rules if world.tick else ()
        met = next((r.text for r in now if r.met(value_of(world, r.formula), world.tick)), None)
        if met is not None:
            manifest["ended"] = {"by": met, "tick": world.tick}
            world.stop()
        if note_requests(world, manifest):
            keep_manifest(folder, manifest)

    start = time.perf_counter()
    try:
        with stopping(world) as pass_on, listening(world.before_tick, look):
            while world.tick < until and not world.stopped:
                goal = min(
                    until,
                    (world.tick // every + 1) * every if every else until,
                    first + 1 if world.tick == first else until,
                )
                at = world.tick
                world.run(goal - at, None if progress is None else _of_all(progress, at, until))
                if at == first:
                    manifest["startup_seconds"], start = time.perf_counter() - begin, time.perf_counter()
                if every and world.tick % every == 0 and world.tick < until:
                    keep_checkpoint(world, folder, manifest)
                    manifest |= _state(world) | folder.written
                    keep_manifest(folder, manifest)
        whole = True
    except OSError as error:
        raise Halted(_cannot_write(error, world, path)) from error
    finally:
        manifest["wall_seconds"] = spent + time.perf_counter() - start
        close(
            world,
            folder,
            manifest,
            finished=whole and (world.tick >= until or bool(manifest.get("ended"))),
            last=whole,
        )
    if not manifest["finished"]:
        raise Stopped(world.tick, path)
    pass_on()
    if report and folder.parts.get("series"):  # a run without ticks has nothing to report
        from ecs_eco.analysis.report import write_report

        write_report(path)
    return manifest


def _of_all(progress: Progress, at: int, until: int) -> Progress:
    """Return a progress function that converts ticks of one part of the run to ticks of the whole run."""
    return lambda done, _: progress(at + done, until)


def close(world: World, folder: Folder, manifest: dict[str, Any], finished: bool, last: bool) -> None:
    """Write the remaining records, a last checkpoint if the tick is complete, and the manifest."""
    try:
        world.recorder.flush()
        if last:
            keep_checkpoint(world, folder, manifest)
        digest = world.digest() if world.underway is None else ""
        manifest |= _state(world) | {"finished": finished, "digest": digest, **folder.written}
        keep_manifest(folder, manifest)
        folder.describe()
    except OSError as error:
        raise Halted(_cannot_write(error, world, folder.path)) from error


def _state(world: World) -> dict[str, Any]:
    return {
        "done": world.tick,
        "causes": world.causes,
        "intervened": [list(done) for done in world.intervened],
    }


def _cannot_write(error: OSError, world: World, path: Path) -> str:
    kept = sorted((path / "checkpoints").glob(f"tick-*{checkpoint.SUFFIX}"))
    last, why = "", error.strerror or error
    if kept:
        tick = checkpoint.tick_of(kept[-1])
        last = f"; the last checkpoint is from tick {tick}: free some space, then run: ecs-eco resume {path}"
    return f"{path}: writing failed at tick {world.tick}: {why}; everything recorded before is intact{last}"
