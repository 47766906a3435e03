"""The files of a run: each contains the run's id, and each part also contains the previous part's seal.

The id is a hash of everything that determines the run, so identical runs write identical files. The id cannot
cover manual interventions, which happen later. The chain of seals distinguishes runs that differ only in such
interventions, and reveals missing, swapped or extra parts.
"""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ecs_eco.engine import files
from ecs_eco.engine.errors import ForeignFile, RecordingError
from ecs_eco.record import seal

KEY = "ecs-eco.part"  # key in the footer of each part
DECIDES = (
    "config",
    "seed",
    "policies",
    "weights",
    "learn",
    "controls",
    "snapshot_every",
    "versions",
    "forked",
)
FORMAT = 2  # format of manifests; manifests in format 1 have no id


class Mark(NamedTuple):
    """A part's identity: its run, its kind, its number within that kind, and the previous part's seal."""

    run: str
    world: str
    seed: int
    kind: str
    number: int
    after: str  # "" for the first part

    def text(self) -> str:
        """Return the mark as text for the footer."""
        return json.dumps(self._asdict())


def identity(manifest: Mapping[str, Any]) -> str:
    """Return the id of the run that a manifest describes: 64 hexadecimal digits."""
    return hashlib.sha256(
        json.dumps([manifest.get(key) for key in DECIDES], separators=(",", ":"), sort_keys=True).encode()
    ).hexdigest()


def described(run: str, world: object, seed: int | str | None) -> str:
    """Return a short description of a run for messages."""
    return f"{world}, seed {seed}, id {run[:12]}"


def mark_of(path: Path) -> tuple[Mark | None, str]:
    """Return a part's mark (None if it has none) and its seal. Raises RecordingError."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        files.require_regular(path)
        written = pq.read_metadata(path).metadata or {}
        mark, own = written.get(KEY.encode()), written.get(seal.KEY.encode(), b"").decode()
        return None if mark is None else Mark(**json.loads(mark)), own
    except (pa.ArrowException, ValueError, TypeError) as error:
        raise RecordingError(f"{path}: is damaged: {error}") from None
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error}") from None


def parts(run: Path, kind: str, manifest: Mapping[str, Any]) -> list[Path]:
    """Return a run's parts of one kind, in order, after checking that they belong to the run.

    An unfinished run may have more parts than the manifest lists. Raises ForeignFile if a part belongs to
    another run or position, RecordingError if parts are missing.
    """
    paths = listed(run / kind)
    if not manifest:
        return paths
    count = int(manifest.get("parts", {}).get(kind, 0))
    if len(paths) < count:
        raise RecordingError(f"{run}: {count - len(paths)} of {count} parts of {kind} are missing")
    heads = manifest.get("heads", {})
    after = ""
    for number, path in enumerate(paths):
        after = check_part(path, kind, number, after, manifest)
        if number == count - 1 and "id" in manifest and heads.get(kind) != after:
            raise ForeignFile(
                f"{path}: is not the last recorded part of {kind}: it belongs to another run of {_run(manifest)}"
            )
    if len(paths) > count and manifest.get("finished") and "id" in manifest:
        raise ForeignFile(
            f"{paths[count]}: is an extra part: the manifest of this finished run "
            f"lists {count} parts of {kind}"
        )
    return paths


def listed(folder: Path) -> list[Path]:
    """Return the files in a folder that are named like parts, sorted by number."""
    return sorted(folder.glob("part-*.parquet"), key=lambda path: (len(path.name), path.name))


def check_part(path: Path, kind: str, number: int, after: str, manifest: Mapping[str, Any]) -> str:
    """Return a part's seal; raise ForeignFile if the part does not belong at this position of the run."""
    mark, own = mark_of(path)
    run = manifest.get("id")
    if mark is None and run is None:
        return own
    if mark is None:
        raise ForeignFile(f"{path}: has no run id, but is in the folder of {_run(manifest)}")
    if mark.run != run:
        here = "in an older format, or created by hand" if run is None else _run(manifest)
        raise ForeignFile(
            f"{path}: belongs to another run ({described(mark.run, mark.world, mark.seed)}), "
            f"not to this one ({here})"
        )
    if (mark.kind, mark.number) != (kind, number) or path.name != name_of(number):
        raise ForeignFile(
            f"{path}: is {name_of(mark.number)} of {mark.kind}, but is stored as {name_of(number)} of {kind}"
        )
    if mark.after != after:
        raise ForeignFile(
            f"{path}: does not follow {path.with_name(name_of(number - 1)) if number else 'nothing'}: "
            f"one of them is damaged or belongs to another run of {_run(manifest)}"
        )
    return own


def check_checkpoint(manifest: Mapping[str, Any], path: Path, meta: Mapping[str, Any]) -> dict[str, Any]:
    """Return the recording state in a checkpoint. Raises ForeignFile if it is from another run."""
    about = meta.get("run") or {}
    if "id" not in about:
        raise ForeignFile(f"{path}: has no run id, but is in the folder of {_run(manifest)}")
    if about["id"] != manifest.get("id"):
        other = described(about["id"], meta.get("name"), meta["clock"]["seed"])
        raise ForeignFile(f"{path}: belongs to another run ({other}), not to this one ({_run(manifest)})")
    return dict(about)


def name_of(number: int) -> str:
    """Return the file name of a part."""
    return f"part-{number:05d}.parquet"


def _run(manifest: Mapping[str, Any]) -> str:
    return described(manifest.get("id") or "none", manifest.get("world"), manifest.get("seed"))
