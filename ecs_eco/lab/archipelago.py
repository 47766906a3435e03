"""Run an archipelago from barrier to barrier, writing its manifest at each one."""

import time
from collections.abc import Mapping
from concurrent.futures import BrokenExecutor, Executor
from contextlib import nullcontext
from pathlib import Path
from typing import Any, Self

from ecs_eco.analysis.archipelago import write_archipelago
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.loading import WorldSource
from ecs_eco.config.models.archipelago import Archipelago as Plan
from ecs_eco.ecosystem import World
from ecs_eco.engine.arguments import called_with, whole_number
from ecs_eco.engine.errors import Halted, RecordingError, refusal
from ecs_eco.lab import island
from ecs_eco.lab.executors import LOCAL, engine, prepare
from ecs_eco.lab.work import run_jobs
from ecs_eco.record import container
from ecs_eco.record.archipelago import ISLANDS, Manifest, digest_of, read, write
from ecs_eco.record.checkpoint import name_of
from ecs_eco.record.claim import Claim, claimed
from ecs_eco.record.code import keep_copies, noted, sources
from ecs_eco.record.folder import check_content, git_commit
from ecs_eco.record.seal import read_manifest
from ecs_eco.runs.begin import policies_as_json
from ecs_eco.runs.run import Stopped

MOST_LOSSES = 100  # how often an island's worker can be lost between two barriers before the run stops


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
            name: self.folder / ISLANDS / name for name in self.manifest["config"]["archipelago"]["islands"]
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
            "snapshot_every": snapshot_every,
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
            self.islands[name] / "checkpoints" / name_of(self.tick), record=False, trust=trust
        )

    def run(
        self,
        until: int | None = None,
        workers: int | None = 1,
        on: str | Executor = LOCAL,
        progress: island.Progress | None = None,
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
        until = self.manifest["ticks"] if until is None else until
        if until < self.tick:
            raise RecordingError(f"{self.folder}: is already at tick {self.tick}, later than until={until}")
        self.manifest |= {"ticks": until, "finished": self.tick >= until}
        start, spent = time.perf_counter(), float(self.manifest["wall_seconds"])
        with Claim(self.folder) if claim is None else nullcontext(), engine(on, workers) as pool:
            container.may_continue(self.folder, self.manifest, Manifest)
            for path in self.islands.values():
                if (path / "manifest.json").is_file():
                    check_content(path, read_manifest(path)["parts"])
            write(self.folder, self.manifest)
            if self.tick < until:
                first = island.config_of(self.folder, self.manifest, trust, next(iter(self.islands)))
                prepare(pool, self.folder, first)
            try:
                while self.tick < until:
                    self._stretch(pool, until, threads, trust, progress)
                    self.manifest["wall_seconds"] = spent + time.perf_counter() - start
                    write(self.folder, self.manifest)
            except KeyboardInterrupt:
                raise Stopped(self.tick, self.folder) from None
            finally:
                island.forget(self.folder.absolute())
            if report:
                calls = {name: (island.report, str(self.folder.absolute()), name) for name in self.islands}
                run_jobs(calls, pool, lambda *_: None, _ended, MOST_LOSSES)
                write_archipelago(self.folder)
        return self.manifest

    def _stretch(
        self, pool: Executor, until: int, threads: int, trust: bool, progress: island.Progress | None
    ) -> None:
        """Run all islands to the next barrier, and record their state there."""
        every = Plan.model_validate(self.manifest["config"]["archipelago"]).migration_interval
        start = self.tick
        goal = min(until, (start // every + 1) * every)
        root = str(self.folder.absolute())
        calls = {name: (island.advance, root, name, start, goal, threads, trust) for name in self.islands}

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
