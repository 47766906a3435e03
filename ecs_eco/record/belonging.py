"""The files of a run: each has the run's id, and each part has the seal of the previous part.

The id is a hash of everything that determines the run, so equal runs write equal files. It cannot cover
interventions by hand, which come later. The chain of seals distinguishes runs that differ only in these, and
reveals missing, swapped or extra parts.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ecs_eco.engine import files
from ecs_eco.engine.errors import ForeignFile, RecordingError
from ecs_eco.record import seal

KEY = "ecs-eco.part"  # in the footer of a part
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
FORMAT = 2  # of manifests; format 1 had no ids


class Mark(NamedTuple):
    """The identity of a part: its run, its kind, its number among the parts of its kind, and the seal of
    the previous part."""

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
    """Return the id of a manifest's run: 64 hexadecimal digits."""
    return hashlib.sha256(
        json.dumps([manifest.get(key) for key in DECIDES], separators=(",", ":"), sort_keys=True).encode()
    ).hexdigest()


def described(run: str, world: object, seed: int | str | None) -> str:
    """Describe a run in words."""
    return f"{world}, seed {seed}, id {run[:12]}"


def mark_of(path: Path) -> tuple[Mark | None, str]:
    """Return the mark of a part, None if it has none, and its seal. Raises RecordingError."""
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
    """Return the parts of a kind in a run folder, in order, after checking that they belong to the run.

    An unfinished run may have more parts than the manifest lists. Raises ForeignFile for a part of another
    run or position, RecordingError for missing parts.
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
    """Return the files in a folder with names of parts, by number."""
    return sorted(folder.glob("part-*.parquet"), key=lambda path: (len(path.name), path.name))


def check_part(path: Path, kind: str, number: int, after: str, manifest: Mapping[str, Any]) -> str:
    """Return the seal of a part at this position of a run; raise ForeignFile if it does not belong there."""
    mark, own = mark_of(path)
    run = manifest.get("id")
    if mark is None and run is None:
        return own
    if mark is None:
        raise ForeignFile(f"{path}: names no run, but is in the folder of {_run(manifest)}")
    if mark.run != run:
        here = "of an older format, or made by hand" if run is None else _run(manifest)
        raise ForeignFile(
            f"{path}: belongs to another run ({described(mark.run, mark.world, mark.seed)}), "
            f"not to this one ({here})"
        )
    if (mark.kind, mark.number) != (kind, number) or path.name != name_of(number):
        raise ForeignFile(
            f"{path}: is {name_of(mark.number)} of {mark.kind}, "
            f"but is in the place of {name_of(number)} of {kind}"
        )
    if mark.after != after:
        raise ForeignFile(
            f"{path}: does not follow {path.with_name(name_of(number - 1)) if number else 'nothing'}: "
            f"one of the two is damaged or belongs to another run of {_run(manifest)}"
        )
    return own


def check_checkpoint(manifest: Mapping[str, Any], path: Path, meta: Mapping[str, Any]) -> dict[str, Any]:
    """Return the state of the recording in a checkpoint. Raises ForeignFile if it is of another run."""
    about = meta.get("run") or {}
    if "id" not in about:
        raise ForeignFile(f"{path}: names no run, but is in the folder of {_run(manifest)}")
    if about["id"] != manifest.get("id"):
        other = described(about["id"], meta.get("name"), meta["clock"]["seed"])
        raise ForeignFile(f"{path}: belongs to another run ({other}), not to this one ({_run(manifest)})")
    return dict(about)


def name_of(number: int) -> str:
    """Return the file name of a part."""
    return f"part-{number:05d}.parquet"


def _run(manifest: Mapping[str, Any]) -> str:
    return described(manifest.get("id") or "none", manifest.get("world"), manifest.get("seed"))
