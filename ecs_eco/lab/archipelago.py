"""An archipelago, run from barrier to barrier: its manifest, and the task of one island, which gives the same
result on any machine, however often it is repeated."""

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import BrokenExecutor, Executor
from contextlib import nullcontext
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from ecs_eco.analysis.archipelago import write_archipelago
from ecs_eco.analysis.report import write_report
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.loading import WorldSource, island_of
from ecs_eco.config.models.archipelago import Archipelago as Plan
from ecs_eco.ecosystem import World
from ecs_eco.engine.arguments import called_with, optional_number, whole_number
from ecs_eco.engine.errors import CheckpointError, ForeignFile, Halted, RecordingError, refusal
from ecs_eco.lab.executors import LOCAL, engine, prepare
from ecs_eco.lab.pool import finishing, once_free
from ecs_eco.lab.work import run_jobs
from ecs_eco.life.migration import Migrants, admit, copied, leave
from ecs_eco.record import checkpoint, container, seal
from ecs_eco.record.archipelago import FILE, ISLANDS, Manifest, check_island, digest_of, read
from ecs_eco.record.claim import Claim, claim_new, claimed
from ecs_eco.record.code import keep_copies, noted, recorded, sources
from ecs_eco.record.folder import check_content, git_commit
from ecs_eco.runs.begin import begin, begun, keep_manifest, policies_as_json
from ecs_eco.runs.run import Stopped, go_on, manifest_of, read_manifest, restored, snapshots
from ecs_eco.space import gate
from ecs_eco.worlds.policies import weights_files

FOLDER = "exports"
KEEP = 3  # number of checkpoints kept per island
PATIENCE = 60.0  # [s] to wait for a worker that is ending to release an island's folder
OWN = {"uid": np.dtype(np.uint64), "born": np.dtype(np.int64), "to": np.dtype(np.int64)}
MOST_LOSSES = 100  # how often an island's worker can be lost between two barriers before the run stops

Progress = Callable[[int, int], None]  # receives the ticks done and planned


class Archipelago:
    """Islands that exchange migrants: a folder with one world per island.

    `from_config` creates such a folder; `Archipelago(folder)` opens one.

    Parameters
    ----------
    folder : str or Path
        Folder of an archipelago.

    Attributes
    ----------
    islands : dict of str to Path
        Run folder of each island.
    manifest : dict

    Examples
    --------
    >>> from ecs_eco.lab import Archipelago
    >>> moth = {
    ...     "count": 30,
    ...     "body": {"radius": 0.1},
    ...     "locomotion": {"speed": {"fly": 0.5}},
    ...     "actions": {"speed": ["fly"]},
    ...     "always_on": ["fly"],
    ... }
    >>> plan = {"islands": 2, "migration_interval": 5, "migration_probability": {"moth": 0.2}}
    >>> pair = {"format": 1, "name": "pair", "space": {"size": [20.0, 20.0]}, "species": {"moth": moth}}
    >>> moths = Archipelago.from_config(pair | {"archipelago": plan}, seed=1, ticks=10, out="moths")
    >>> moths.run(report=False)["finished"], moths.tick
    (True, 10)
    >>> sum(moths.world(name).table("moth").n for name in moths.islands)
    60
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        self.manifest = read(self.folder)
        self.islands = {
            name: self.folder / ISLANDS / name
            for name in Plan.model_validate(self.manifest["config"]["archipelago"]).names
        }

    @classmethod
    def from_config(
        cls,
        config: WorldSource,
        seed: int | None = None,
        ticks: int | None = None,
        out: str | Path | Claim = "archipelago",
        policies: str | dict[str, str] = "trained",
        learn: bool | Mapping[str, bool] | None = None,
        *,
        snapshot_every: int | None = None,
        record: str | None = None,
        command: str | None = None,
        trust: bool = False,
    ) -> Self:
        """Create the folder of an archipelago at tick 0.

        Parameters
        ----------
        config : str, Path, Mapping or WorldConfig
            A world with an `archipelago` section.
        seed : int, optional
            Seed from which the islands' seeds are derived; default: `seed` in the world file.
        ticks : int, optional
            Planned length; default: `ticks` in the world file.
        out : str or Path, default "archipelago"
            New or empty folder.
        policies : str or Mapping, default "trained"
            Initial policies, as in `World.from_config`.
        learn : bool or Mapping of str to bool, optional
            Which species learn; default: as set in the world file.
        snapshot_every, record, command, trust
            As in `run_to_folder`.

        Returns
        -------
        Archipelago

        Raises
        ------
        ConfigError
            If the world has no islands.
        FileExistsError
            If `out` is not empty.
        """
        config = config if isinstance(config, WorldConfig) and not trust else load(config, trust=trust)
        if config.archipelago is None or config.archipelago.here is not None:
            raise refusal(
                ("archipelago",),
                "is missing: this world has no islands",
                allowed="a table with islands, migration_interval and migration_probability",
            )
        manifest = {
            "world": config.name,
            "title": config.title,
            "config": config.resolved(),
            "config_hash": config.config_hash,
            "folder": str(config.folder.absolute()),
            "code": noted(sources(config)),
            "seed": config.seed if seed is None else seed,
            "ticks": config.ticks if ticks is None else whole_number("ticks", ticks, 1),
            "policies": policies_as_json(policies),
            "learn": learn,
            "snapshot_every": optional_number("snapshot_every", snapshot_every, 1),
            "record": record,
            "command": command,
            "git_commit": git_commit(),
            "tick": 0,
            "islands": {},
            "digest": None,
            "finished": False,
            "wall_seconds": 0.0,
        }
        with claimed(out) as claim:
            keep_copies(sources(config), claim.path)
            container.begin(claim.path, Manifest, manifest)
            return cls(claim.path)

    @property
    def tick(self) -> int:
        """Tick that all islands have reached."""
        return int(self.manifest["tick"])

    @property
    def digest(self) -> str | None:
        """Hash of all islands' digests at `tick`; None before the first barrier."""
        return self.manifest["digest"]

    def world(self, name: str, trust: bool = False) -> Any:
        """Return the world of one island at the current tick.

        Parameters
        ----------
        name : str
            Name of the island.
        trust : bool, default False
            Whether code listed in the world file can run in this process.

        Returns
        -------
        World
        """
        return World.restore(
            self.islands[name] / "checkpoints" / checkpoint.name_of(self.tick), record=False, trust=trust
        )

    def run(
        self,
        until: int | None = None,
        workers: int | None = 1,
        on: str | Executor = LOCAL,
        progress: Progress | None = None,
        *,
        threads: int = 1,
        report: bool = True,
        trust: bool = False,
        claim: Claim | None = None,
    ) -> dict[str, Any]:
        """Run all islands, with migration at each barrier, and return the manifest.

        Parameters
        ----------
        until : int, optional
            Last tick; default: the planned end.
        workers : int, optional
            Number of processes; default: 1.
        on : str or Executor, default "local"
            "local", "ray", or an executor whose workers can access the folder under the same path.
        progress : callable, optional
            `progress(done, total)`, in ticks summed over islands.
        threads : int, default 1
            Number of threads per island.
        report : bool, default True
            Whether to write reports at the end.
        trust : bool, default False
            Whether code listed in the world file can run.
        claim : Claim, optional
            Lock on the folder, if you already hold it.

        Returns
        -------
        dict

        Raises
        ------
        Stopped
            On Ctrl-C (a subclass of KeyboardInterrupt); `run` then continues from the last barrier.
        RecordingError
            If `until` is before the current tick.
        """
        called_with("progress", progress, "done", "total")
        until = self.manifest["ticks"] if until is None else whole_number("until", until)
        if until < self.tick:
            raise RecordingError(f"{self.folder}: is already at tick {self.tick}, later than until={until}")
        self.manifest |= {"ticks": until, "finished": self.tick >= until}
        start, spent = time.perf_counter(), float(self.manifest["wall_seconds"])
        with Claim(self.folder) if claim is None else nullcontext(), engine(on, workers) as pool:
            container.may_continue(self.folder / FILE, {"target": self.manifest})
            for path in self.islands.values():
                if (path / "manifest.json").is_file():
                    check_content(path, seal.read_manifest(path)["parts"])
            container.write(self.folder, Manifest, self.manifest)
            if self.tick < until:
                first = config_of(self.folder, self.manifest, trust, next(iter(self.islands)))
                prepare(pool, self.folder, first)
            try:
                while self.tick < until:
                    self._stretch(pool, until, threads, trust, progress)
                    self.manifest["wall_seconds"] = spent + time.perf_counter() - start
                    container.write(self.folder, Manifest, self.manifest)
            except KeyboardInterrupt:
                raise Stopped(self.tick, self.folder) from None
            finally:
                for path in self.islands.values():
                    _live.pop(path.absolute(), None)
            if report:
                calls = {name: (write_report, path.absolute()) for name, path in self.islands.items()}
                run_jobs(calls, pool, lambda *_: None, _ended, MOST_LOSSES)
                write_archipelago(self.folder)
        return self.manifest

    def _stretch(
        self, pool: Executor, until: int, threads: int, trust: bool, progress: Progress | None
    ) -> None:
        """Run all islands to the next barrier, and record their state there."""
        every = Plan.model_validate(self.manifest["config"]["archipelago"]).migration_interval
        start = self.tick
        goal = min(until, (start // every + 1) * every)
        root = str(self.folder.absolute())
        calls = {name: (advance, root, name, start, goal, threads, trust) for name in self.islands}

        def note(done: int, _: int) -> None:
            if progress is not None and done:
                progress(start * len(calls) + done * (goal - start), until * len(calls))

        done = run_jobs(calls, pool, note, _ended, MOST_LOSSES)
        self.manifest |= {
            "tick": goal,
            "finished": goal >= until,
            "islands": {name: done[name] for name in calls},
        }
        self.manifest["digest"] = digest_of(self.manifest["islands"])


def _ended(name: str, error: BaseException) -> None:
    if isinstance(error, BrokenExecutor):
        raise Halted(f"the worker of {name} was lost repeatedly: {error}") from error
    raise error


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
            **{f"{species}/columns/{name}": column for name, column in migrants.columns.items()},
        }
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
        if (
            species not in wander
            or array.ndim < 1
            or (name in OWN and (array.ndim, array.dtype) != (1, OWN[name]))
        ):
            raise CheckpointError(f"{file}: {key}: is not a migrants file")
        groups.setdefault(species, {})[name.removeprefix("columns/")] = array
    out = {}
    for species, group in groups.items():
        if not OWN.keys() <= group.keys() or len(set(map(len, group.values()))) > 1:
            raise CheckpointError(f"{file}: {species}: columns are missing or differ in length")
        uid, born, to = (group.pop(name) for name in OWN)
        out[species] = Migrants(uid, born, to, group)
    return out


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
    container.may_continue(root / FILE, {"target": plan})

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
            try:
                admit(world, arrivals(root, plan["hash"], world, start))
                gate.admit(world)
            except ValueError as error:
                wrong = f"{path}: a migrant that arrives at tick {start}: {error}"
                raise (CheckpointError(wrong) if type(error) is ValueError else error) from None
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
    world = World.from_config(config, policies=policies, threads=threads, learn=learn, record=False)
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
