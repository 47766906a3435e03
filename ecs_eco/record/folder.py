"""The folder of a run: manifest, Parquet series, births, deaths and snapshots, figures and a report."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco._lazy import Later
from ecs_eco.engine.errors import RecordingError
from ecs_eco.record.belonging import Mark, listed, name_of, parts
from ecs_eco.record.claim import Claim, half_written
from ecs_eco.record.events import EVENTS

if TYPE_CHECKING:
    from ecs_eco.record import dictionary, parquet
    from ecs_eco.space.world import SpatialWorld
else:
    parquet, dictionary = Later("ecs_eco.record.parquet"), Later("ecs_eco.record.dictionary")


FIRST = ("series", "births", "deaths", "snapshots")  # folders of parts
LATER = ("matter", "learning", "actions", "arrivals", "departures", "details-*")  # of some runs
FOLDERS = (*FIRST, *LATER, "checkpoints", "policies", "figures")  # in a run


class Folder:
    """The folder of one run. Files are written atomically: to a temporary file, synced, then renamed.

    `run` identifies the run in every part: its id, world and seed. `claim` is checked before each write.
    """

    def __init__(
        self,
        path: Path,
        world: SpatialWorld,
        run: Mapping[str, Any] | None = None,
        claim: Claim | None = None,
    ) -> None:
        self.path, self.world, self.run, self.claim = path, world, run, claim
        self.parts = dict.fromkeys(FIRST, 0)
        self.heads: dict[str, str] = {}  # the seal of each kind's last part

    def sink(self, kind: str, columns: dict[str, np.ndarray]) -> None:
        """Write one block of rows as a Parquet part."""
        words = {name: known for name, known in self.world.recorder.words(kind).items() if name in columns}
        if kind == "deaths":
            columns = columns | {"cause": columns["cause"].astype(np.int32) - 1}
            words["cause"] = self.world.causes
        missing = {}
        if kind in EVENTS:
            missing = self.world.recorder.fields.missing(columns["species"])
        if self.claim is not None:
            self.claim.check()
        folder, number = self.path / kind, self.parts.setdefault(kind, 0)
        folder.mkdir(exist_ok=True)
        after = self.heads.get(kind, "")
        mark = None if self.run is None else Mark(**self.run, kind=kind, number=number, after=after)
        table = dictionary.described(parquet.to_arrow(columns, words, missing), kind, self.world)
        self.heads[kind] = parquet.write_part(table, folder / name_of(number), mark)
        self.parts[kind] += 1

    @property
    def written(self) -> dict[str, Any]:
        """The number of parts of each kind, and the seal of each kind's last part."""
        return {"parts": dict(self.parts), "heads": dict(self.heads)}

    def describe(self) -> None:
        """Write the data dictionary of everything recorded so far."""
        dictionary.write_dictionary(self.path, self.parts, self.world)

    def go_on_from(self, written: Mapping[str, Any], manifest: Mapping[str, Any]) -> None:
        """Continue from a checkpoint's state. Raises ForeignFile or RecordingError if parts do not match."""
        try:
            self.parts = {kind: int(n) for kind, n in written["parts"].items()}
            self.heads = dict(written["heads"])
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            raise RecordingError(
                f"{self.path / 'checkpoints'}: the last checkpoint lacks the position of its run: {error}"
            ) from None
        for kind in self._kinds():
            parts(self.path, kind, {**manifest, **written, "finished": False})

    def forget_later(self) -> None:
        """Remove half-written files, and parts from the next number on, which will be recorded again."""
        for kind in self._kinds():
            # in reverse order, so that no gap remains if the process is killed
            for part in reversed(listed(self.path / kind)[self.parts.get(kind, 0) :]):
                part.unlink()
        for half in leftovers(self.path):
            half.unlink(missing_ok=True)

    def _kinds(self) -> list[str]:
        later = [folder.name for kind in LATER for folder in sorted(self.path.glob(kind))]
        return list(dict.fromkeys([*self.parts, *later]))


def check_content(path: Path, counts: Mapping[str, int]) -> None:
    """Raise RecordingError if any of the first `counts` parts of each kind is damaged."""
    for kind, count in counts.items():
        for part in listed(path / kind)[:count]:
            try:
                parquet.open_part(part, needed=True)
            except RecordingError as error:
                raise RecordingError(
                    f"{error}, so the run cannot continue. Fork it from a checkpoint instead: ecs-eco "
                    f"resume {path} --out NEW --until LATER"
                ) from None


def leftovers(path: Path) -> list[Path]:
    """Return the half-written files that a killed run left in its folder, recognized by name."""
    return [
        half
        for folder in [path, *(own for name in FOLDERS for own in path.glob(name))]
        for half in half_written(folder)
    ]


def git_commit() -> str | None:
    """Return the commit of the checkout that the package runs from, or None."""
    try:
        done = subprocess.run(
            ["git", "rev-parse", "HEAD"],
            cwd=Path(__file__).parent,
            capture_output=True,
            text=True,
            timeout=5,
            check=False,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None if done.returncode == 0 else None
